/* Decoder of the telemetry of meerkat-mwd, for a receiver in C99. No allocation, no global state. docs/telemetry.md
 * explains the layout, which mwd_telemetry_layout.h holds as text. */
#ifndef MWD_TELEMETRY_H
#define MWD_TELEMETRY_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Longest frame without COBS: kind, sequence number, payload of 1,200 bytes, check. */
#define MWD_DECODED_SIZE 1207

/* Finds frames in a stream of bytes; all zero at the start. */
typedef struct MwdDecoder {
    uint8_t bytes[MWD_DECODED_SIZE];
    size_t used;
    uint8_t left;       /* bytes until the next code */
    uint8_t zero_next;  /* 1 if a zero stands there */
    uint8_t broken;     /* 1 if the frame is no frame */
} MwdDecoder;

/* A frame whose check was right; it points into the decoder, until the next byte. */
typedef struct MwdFrame {
    uint8_t kind;
    uint16_t sequence;
    const uint8_t *payload;
    size_t length;
} MwdFrame;

/* Takes one byte; returns 1 if it ended a frame, which `frame` then is. */
int mwd_decoder_push(MwdDecoder *decoder, uint8_t byte, MwdFrame *frame);

/* Part of a payload, in the order of its bytes. */
typedef enum MwdPart {
    MWD_PART_STRUCT,     /* members follow */
    MWD_PART_LIST,       /* `number` values without names follow */
    MWD_PART_END,        /* of a struct, a list or a choice */
    MWD_PART_NONE,       /* a value that is absent */
    MWD_PART_NUMBER,     /* `number` */
    MWD_PART_BOOL,       /* `number`: 0 or 1 */
    MWD_PART_REAL,       /* `real` */
    MWD_PART_TEXT,       /* `text`, `text_length` */
    MWD_PART_CHOICE,     /* `text`: the name of the choice */
    MWD_PART_CHOICE_OF,  /* `text`: the name of the choice; its value follows without a name */
    MWD_PART_FLAG        /* between STRUCT and END of a `flags`: `text` is set */
} MwdPart;

typedef struct MwdValue {
    uint64_t number;
    float real;
    const char *text;
    size_t text_length;
    int is_flags; /* of MWD_PART_LIST: the values are flags */
} MwdValue;

/* Is told each part with the name of its member, which no zero ends; without a name `length` is 0. */
typedef void (*MwdListener)(void *context, const char *name, size_t length, MwdPart part, const MwdValue *value);

/* Walks through a payload. Returns 0, or -1 for a payload of another version; what was told before then is void. */
int mwd_payload_walk(const MwdFrame *frame, MwdListener listener, void *context);

#ifdef __cplusplus
}
#endif

#endif
