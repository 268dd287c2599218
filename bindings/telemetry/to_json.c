/* Prints a capture as mwd_telemetry.py does, one JSON object a frame: `to_json CAPTURE`. */
#include "mwd_telemetry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A payload's JSON is shorter than that. */
typedef struct Text {
    char bytes[65536];
    size_t used;
    char closing[32];
    int depth;
    int first;
} Text;

static void put(Text *text, const char *bytes, size_t length) {
    if (text->used + length < sizeof text->bytes) {
        memcpy(text->bytes + text->used, bytes, length);
        text->used += length;
    }
}

static void quoted(Text *text, const char *bytes, size_t length) {
    put(text, "\"", 1);
    for (size_t i = 0; i < length; i++) {
        char escaped[8];
        unsigned char byte = (unsigned char)bytes[i];
        if (byte < 0x20 || byte == '"' || byte == '\\') {
            int written = snprintf(escaped, sizeof escaped, "\\u%04x", byte);
            put(text, escaped, (size_t)written);
        } else {
            put(text, bytes + i, 1);
        }
    }
    put(text, "\"", 1);
}

static void open(Text *text, const char *opening, char closing) {
    put(text, opening, 1);
    if (text->depth < (int)sizeof text->closing) {
        text->closing[text->depth++] = closing;
    }
    text->first = 1;
}

static void listen(void *context, const char *name, size_t length, MwdPart part, const MwdValue *value) {
    Text *text = (Text *)context;
    char number[40];
    if (part == MWD_PART_FLAG) {
        put(text, " | ", text->first ? 0 : 3);
        put(text, value->text, value->text_length);
        text->first = 0;
        return;
    }
    if (part != MWD_PART_END) {
        if (!text->first) {
            put(text, ",", 1);
        }
        if (length > 0) {
            quoted(text, name, length);
            put(text, ":", 1);
        }
        text->first = 0;
    }
    switch (part) {
    case MWD_PART_STRUCT:
        open(text, "{", '}');
        break;
    case MWD_PART_LIST:
        open(text, value->is_flags ? "\"" : "[", value->is_flags ? '"' : ']');
        break;
    case MWD_PART_CHOICE_OF:
        open(text, "{", '}');
        quoted(text, value->text, value->text_length);
        put(text, ":", 1);
        break;
    case MWD_PART_END:
        if (text->depth > 0) {
            put(text, &text->closing[--text->depth], 1);
        }
        text->first = 0;
        break;
    case MWD_PART_NONE:
        put(text, "null", 4);
        break;
    case MWD_PART_BOOL:
        put(text, value->number ? "true" : "false", value->number ? 4 : 5);
        break;
    case MWD_PART_NUMBER:
        put(text, number, (size_t)snprintf(number, sizeof number, "%llu", (unsigned long long)value->number));
        break;
    case MWD_PART_REAL:
        if (isfinite(value->real)) {
            put(text, number, (size_t)snprintf(number, sizeof number, "%.9g", (double)value->real));
        } else {
            put(text, "null", 4);
        }
        break;
    case MWD_PART_TEXT:
    case MWD_PART_CHOICE:
        quoted(text, value->text, value->text_length);
        break;
    case MWD_PART_FLAG:
        break;
    }
}

int main(int count, char **arguments) {
    static MwdDecoder decoder;
    static Text text;
    MwdFrame frame;
    int byte;
    FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
    if (file == NULL) {
        fprintf(stderr, "usage: to_json CAPTURE\n");
        return 2;
    }
    while ((byte = fgetc(file)) != EOF) {
        if (!mwd_decoder_push(&decoder, (uint8_t)byte, &frame)) {
            continue;
        }
        text.used = 0;
        text.depth = 0;
        text.first = 0;
        if (mwd_payload_walk(&frame, listen, &text) == 0) {
            printf("{\"sequence\":%u%.*s}\n", (unsigned)frame.sequence, (int)text.used, text.bytes);
        } else {
            printf("{\"sequence\":%u,\"kind\":%u,\"error\":\"another version\"}\n", (unsigned)frame.sequence,
                   (unsigned)frame.kind);
        }
    }
    fclose(file);
    return 0;
}
