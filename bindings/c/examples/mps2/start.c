/* The example on an emulated Cortex-M4F: Arm MPS2 with the image AN386, files by semihosting (Arm IHI 0100). */
#include "../replay.h"

#include <stdint.h>

#define SYS_OPEN 0x01
#define SYS_WRITE0 0x04
#define SYS_WRITE 0x05
#define SYS_READ 0x06
#define SYS_EXIT 0x18
#define SYS_EXIT_EXTENDED 0x20
#define APPLICATION_EXIT 0x20026
#define READ_BINARY 1
#define WRITE_BINARY 5

extern uint32_t stack_top, data_start, data_end, data_image, bss_start, bss_end;

static int call(uint32_t operation, const void *arguments) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return (int)r0;
}

static int open_file(const char *name, uint32_t length, uint32_t mode) {
    uint32_t arguments[3] = {(uint32_t)(uintptr_t)name, mode, length};
    return call(SYS_OPEN, arguments);
}

static int input;
static int output;

/* Both hand out a file as blocks: a call for each number would stop the emulator a million times. */
static uint8_t in[4096];
static uint32_t in_used = 0, in_filled = 0;
static uint8_t out[4096];
static uint32_t out_filled = 0;

int io_read(void *buffer, size_t bytes) {
    uint8_t *to = (uint8_t *)buffer;
    for (size_t i = 0; i < bytes; i++) {
        if (in_used == in_filled) {
            uint32_t arguments[3] = {(uint32_t)input, (uint32_t)(uintptr_t)in, sizeof in};
            in_filled = sizeof in - (uint32_t)call(SYS_READ, arguments);
            in_used = 0;
            if (in_filled == 0) {
                return 0;
            }
        }
        to[i] = in[in_used++];
    }
    return 1;
}

static int flush(void) {
    uint32_t arguments[3] = {(uint32_t)output, (uint32_t)(uintptr_t)out, out_filled};
    out_filled = 0;
    return call(SYS_WRITE, arguments) == 0;
}

int io_write(const void *buffer, size_t bytes) {
    const uint8_t *from = (const uint8_t *)buffer;
    for (size_t i = 0; i < bytes; i++) {
        if (out_filled == sizeof out && !flush()) {
            return 0;
        }
        out[out_filled++] = from[i];
    }
    return 1;
}

static void leave(int code) {
    uint32_t arguments[2] = {APPLICATION_EXIT, (uint32_t)code};
    call(SYS_EXIT_EXTENDED, arguments);
    for (;;) {
    }
}

static void fault(void) {
    call(SYS_WRITE0, "a fault\n");
    leave(99);
}

void reset(void);
void reset(void) {
    /* CPACR: full access to the floating-point unit (Armv7-M ARM, B3.2.20). */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\nisb");
    for (uint32_t *to = &data_start, *from = &data_image; to < &data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = &bss_start; to < &bss_end;) {
        *to++ = 0;
    }
    input = open_file("samples.bin", 11, READ_BINARY);
    output = open_file("frames.bin", 10, WRITE_BINARY);
    if (input < 0 || output < 0) {
        leave(98);
    }
    int step = replay();
    if (!flush()) {
        leave(97);
    }
    leave(step);
}

__attribute__((section(".vectors"), used)) static void *const vectors[] = {
    (void *)&stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};
