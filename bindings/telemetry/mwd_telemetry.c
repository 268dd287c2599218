/* Decoder of the telemetry; mwd_telemetry.h says what it does. */
#include "mwd_telemetry.h"

#include "mwd_telemetry_layout.h"

#include <string.h>

/* Deepest nesting of a layout; no layout has more than 12. */
#define DEEPEST 24

static uint32_t crc32c(const uint8_t *bytes, size_t length) {
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ ((crc & 1u) ? 0x82F63B78u : 0u);
        }
    }
    return crc ^ 0xFFFFFFFFu;
}

static void keep(MwdDecoder *decoder, uint8_t byte) {
    if (decoder->used < MWD_DECODED_SIZE) {
        decoder->bytes[decoder->used++] = byte;
    } else {
        decoder->broken = 1;
    }
}

static int check(const MwdDecoder *decoder, MwdFrame *frame) {
    const uint8_t *bytes = decoder->bytes;
    if (decoder->broken || decoder->left > 0 || decoder->used < 7) {
        return 0;
    }
    const uint8_t *end = bytes + decoder->used - 4;
    uint32_t sent = end[0] | (uint32_t)end[1] << 8 | (uint32_t)end[2] << 16 | (uint32_t)end[3] << 24;
    if (crc32c(bytes, decoder->used - 4) != sent) {
        return 0;
    }
    frame->kind = bytes[0];
    frame->sequence = (uint16_t)(bytes[1] | bytes[2] << 8);
    frame->payload = bytes + 3;
    frame->length = decoder->used - 7;
    return 1;
}

int mwd_decoder_push(MwdDecoder *decoder, uint8_t byte, MwdFrame *frame) {
    if (byte == 0) {
        int whole = check(decoder, frame);
        decoder->used = 0;
        decoder->left = decoder->zero_next = decoder->broken = 0;
        return whole;
    }
    if (decoder->left > 0) {
        keep(decoder, byte);
        decoder->left--;
        return 0;
    }
    if (decoder->zero_next) {
        keep(decoder, 0);
    }
    decoder->left = (uint8_t)(byte - 1);
    decoder->zero_next = byte < 255;
    return 0;
}

typedef struct Walk {
    const uint8_t *at;
    const uint8_t *end;
    MwdListener listener;
    void *context;
    int depth;
} Walk;

static void tell(Walk *walk, const char *name, size_t length, MwdPart part, const MwdValue *value) {
    walk->listener(walk->context, name, length, part, value);
}

static size_t word(const char *text) {
    return strcspn(text, " ");
}

/* Lines of the layout; NULL ends them. */
typedef const char *const *Line;

static int is_member(Line line) {
    return *line != NULL && **line == ' ';
}

/* The line that declares a type; its members are the indented lines after it. */
static Line declaration(const char *type, size_t length) {
    for (Line line = MWD_TELEMETRY_LAYOUT; *line != NULL; line++) {
        if (is_member(line) || strncmp(*line, "frame ", 6) == 0) {
            continue;
        }
        const char *name = *line + word(*line) + 1;
        if (word(name) == length && memcmp(name, type, length) == 0) {
            return line;
        }
    }
    return NULL;
}

static int take(Walk *walk, size_t count, const uint8_t **bytes) {
    if ((size_t)(walk->end - walk->at) < count) {
        return -1;
    }
    *bytes = walk->at;
    walk->at += count;
    return 0;
}

static int varint(Walk *walk, int bits, uint64_t *value) {
    *value = 0;
    for (int place = 0; place < (bits + 6) / 7; place++) {
        const uint8_t *byte;
        if (take(walk, 1, &byte) != 0) {
            return -1;
        }
        uint64_t seven = *byte & 0x7Fu;
        if (7 * place + 7 > bits && seven >> (bits - 7 * place) != 0) {
            return -1;
        }
        *value |= seven << (7 * place);
        if (*byte < 0x80) {
            return 0;
        }
    }
    return -1;
}

static int fixed(Walk *walk, size_t count, uint64_t *value) {
    const uint8_t *bytes;
    if (take(walk, count, &bytes) != 0) {
        return -1;
    }
    *value = 0;
    for (size_t i = count; i > 0; i--) {
        *value = *value << 8 | bytes[i - 1];
    }
    return 0;
}

static int one_of_two(Walk *walk, uint64_t *value) {
    return fixed(walk, 1, value) != 0 || *value > 1 ? -1 : 0;
}

static int walk_value(Walk *walk, const char *name, size_t name_length, const char *type, size_t length);

static int walk_list(Walk *walk, const char *name, size_t name_length, const char *type, size_t length,
                     uint64_t count) {
    MwdValue value = {0};
    value.number = count;
    tell(walk, name, name_length, MWD_PART_LIST, &value);
    for (uint64_t i = 0; i < count; i++) {
        if (walk_value(walk, "", 0, type, length) != 0) {
            return -1;
        }
    }
    tell(walk, "", 0, MWD_PART_END, &value);
    return 0;
}

static int walk_flags(Walk *walk, const char *name, size_t name_length, Line line) {
    MwdValue value = {0};
    uint64_t bits;
    if (varint(walk, 16, &bits) != 0) {
        return -1;
    }
    value.is_flags = 1;
    value.number = bits;
    tell(walk, name, name_length, MWD_PART_LIST, &value);
    for (line++; is_member(line); line++) {
        uint64_t bit = 0;
        value.text = *line + 2;
        value.text_length = word(value.text);
        for (const char *digit = value.text + value.text_length + 1; *digit >= '0' && *digit <= '9'; digit++) {
            bit = 10 * bit + (uint64_t)(*digit - '0');
        }
        if (bits & bit) {
            tell(walk, "", 0, MWD_PART_FLAG, &value);
        }
    }
    tell(walk, "", 0, MWD_PART_END, &value);
    return 0;
}

static int walk_named(Walk *walk, const char *name, size_t name_length, const char *type, size_t length) {
    Line line = declaration(type, length);
    MwdValue value = {0};
    if (line == NULL) {
        return -1;
    }
    if (strncmp(*line, "flags ", 6) == 0) {
        return walk_flags(walk, name, name_length, line);
    }
    if (strncmp(*line, "struct ", 7) == 0) {
        tell(walk, name, name_length, MWD_PART_STRUCT, &value);
        for (line++; is_member(line); line++) {
            const char *member = *line + 2;
            const char *of = member + word(member) + 1;
            if (walk_value(walk, member, word(member), of, word(of)) != 0) {
                return -1;
            }
        }
        tell(walk, "", 0, MWD_PART_END, &value);
        return 0;
    }
    if (varint(walk, 32, &value.number) != 0) {
        return -1;
    }
    line++;
    for (uint64_t i = 0; i < value.number && is_member(line); i++) {
        line++;
    }
    if (!is_member(line)) {
        return -1;
    }
    value.text = *line + 2;
    value.text_length = word(value.text);
    if (value.text[value.text_length] != ' ') {
        tell(walk, name, name_length, MWD_PART_CHOICE, &value);
        return 0;
    }
    tell(walk, name, name_length, MWD_PART_CHOICE_OF, &value);
    const char *of = value.text + value.text_length + 1;
    if (walk_value(walk, "", 0, of, word(of)) != 0) {
        return -1;
    }
    tell(walk, "", 0, MWD_PART_END, &value);
    return 0;
}

static int is(const char *type, size_t length, const char *text) {
    return length == strlen(text) && memcmp(type, text, length) == 0;
}

static int walk_plain(Walk *walk, const char *name, size_t name_length, const char *type, size_t length) {
    MwdValue value = {0};
    MwdPart part = MWD_PART_NUMBER;
    int failed;
    if (is(type, length, "u8")) {
        failed = fixed(walk, 1, &value.number);
    } else if (is(type, length, "u16")) {
        failed = varint(walk, 16, &value.number);
    } else if (is(type, length, "u32")) {
        failed = varint(walk, 32, &value.number);
    } else if (is(type, length, "u64")) {
        failed = varint(walk, 64, &value.number);
    } else if (is(type, length, "le16")) {
        failed = fixed(walk, 2, &value.number);
    } else if (is(type, length, "le64")) {
        failed = fixed(walk, 8, &value.number);
    } else if (is(type, length, "bool")) {
        part = MWD_PART_BOOL;
        failed = one_of_two(walk, &value.number);
    } else if (is(type, length, "f32")) {
        part = MWD_PART_REAL;
        failed = fixed(walk, 4, &value.number);
        uint32_t bits = (uint32_t)value.number;
        memcpy(&value.real, &bits, sizeof bits);
    } else if (is(type, length, "text")) {
        const uint8_t *bytes = NULL;
        part = MWD_PART_TEXT;
        failed = varint(walk, 32, &value.number) != 0 || take(walk, (size_t)value.number, &bytes) != 0;
        value.text = (const char *)bytes;
        value.text_length = (size_t)value.number;
    } else {
        return walk_named(walk, name, name_length, type, length);
    }
    if (failed) {
        return -1;
    }
    tell(walk, name, name_length, part, &value);
    return 0;
}

static int walk_value(Walk *walk, const char *name, size_t name_length, const char *type, size_t length) {
    uint64_t count = 0;
    int failed;
    if (walk->depth >= DEEPEST) {
        return -1;
    }
    walk->depth++;
    if (*type == '?') {
        failed = one_of_two(walk, &count);
        if (failed == 0 && count == 0) {
            MwdValue none = {0};
            tell(walk, name, name_length, MWD_PART_NONE, &none);
        } else if (failed == 0) {
            failed = walk_value(walk, name, name_length, type + 1, length - 1);
        }
    } else if (*type == '*') {
        failed = varint(walk, 32, &count);
        if (failed == 0) {
            failed = walk_list(walk, name, name_length, type + 1, length - 1, count);
        }
    } else if (*type == '[') {
        const char *digit = type + 1;
        for (; *digit != ']'; digit++) {
            count = 10 * count + (uint64_t)(*digit - '0');
        }
        failed = walk_list(walk, name, name_length, digit + 1, length - (size_t)(digit + 1 - type), count);
    } else {
        failed = walk_plain(walk, name, name_length, type, length);
    }
    walk->depth--;
    return failed;
}

int mwd_payload_walk(const MwdFrame *frame, MwdListener listener, void *context) {
    Walk walk = {frame->payload, frame->payload + frame->length, listener, context, 0};
    for (Line line = MWD_TELEMETRY_LAYOUT; strncmp(*line, "frame ", 6) == 0; line++) {
        unsigned kind = 0;
        const char *digit = *line + 6;
        for (; *digit != ' '; digit++) {
            kind = 10 * kind + (unsigned)(*digit - '0');
        }
        if (kind == frame->kind) {
            const char *type = digit + 1;
            int failed = walk_value(&walk, type, word(type), type, word(type));
            return failed != 0 || walk.at != walk.end ? -1 : 0;
        }
    }
    return -1;
}
