/* A plugin of QEMU's that counts executed instructions and estimates Cortex-M4F cycles, part by part of a program.
 *
 * A part begins where a function of it is entered, and lasts until another part's is. Debian ships no header of the interface, so
 * what is needed of it is declared here. PVER is the version of the interface: 1 for QEMU 7 and 8, 4 for 10.
 *
 * Cycles: Arm's Cortex-M4 Technical Reference Manual (r0p1, tables 3-1 and 7-1) with memory that never waits; VSQRT taken as VDIV; loads are not
 * pipelined; a taken branch adds 2. A board's flash adds waits of its own, which only a board can count.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))
EXPORT int qemu_plugin_version = PVER;

typedef uint64_t plugin_id;
struct block;
struct insn;
extern void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, void (*)(plugin_id, struct block *));
extern void qemu_plugin_register_vcpu_tb_exec_cb(struct block *, void (*)(unsigned, void *), int, void *);
extern void qemu_plugin_register_atexit_cb(plugin_id, void (*)(plugin_id, void *), void *);
extern void qemu_plugin_outs(const char *);
extern size_t qemu_plugin_tb_n_insns(const struct block *);
extern struct insn *qemu_plugin_tb_get_insn(const struct block *, size_t);
extern uint64_t qemu_plugin_insn_vaddr(const struct insn *);
extern char *qemu_plugin_insn_disas(const struct insn *);
extern size_t qemu_plugin_insn_size(const struct insn *);

enum { PARTS = 32, ENTRIES = 64 };

/* What runs without a branch. */
struct run { uint64_t from, to, instructions, cycles; int part; };
static struct { uint64_t address; int part; } entries[ENTRIES];
static int n_entries;
static struct { uint64_t instructions, cycles; } counts[PARTS];
static int part;
static const struct run *before;

static int starts(const char *text, const char *prefix) { return !strncmp(text, prefix, strlen(prefix)); }

static int registers_in_list(const char *text)
{
    const char *p = strchr(text, '{');
    int n = 1;
    for (; p && *p && *p != '}'; p++) n += *p == ',';
    return n;
}

static int cycles_of(const char *text)
{
    if (starts(text, "vdiv") || starts(text, "vsqrt")) return 14;
    if (starts(text, "vmla") || starts(text, "vmls") || starts(text, "vnml") || starts(text, "vfm") || starts(text, "vfnm")) return 3;
    if (starts(text, "vldr") || starts(text, "vstr")) return strstr(text, " d") ? 3 : 2;
    if (starts(text, "vldm") || starts(text, "vstm") || starts(text, "vpush") || starts(text, "vpop"))
        return 1 + registers_in_list(text) * (strstr(text, "{d") ? 2 : 1);
    if (text[0] == 'v') return 1;
    if (starts(text, "ldm") || starts(text, "stm") || starts(text, "push") || starts(text, "pop")) return 1 + registers_in_list(text);
    if (starts(text, "ldrd") || starts(text, "strd")) return 3;
    if (starts(text, "ldr") || starts(text, "str")) return 2;
    if (starts(text, "sdiv") || starts(text, "udiv")) return 7;
    return 1;
}

static void on_execute(unsigned cpu, void *data)
{
    const struct run *run = data;
    (void)cpu;
    if (before && run->from != before->to) counts[part].cycles += 2;
    if (run->part >= 0) part = run->part;
    counts[part].instructions += run->instructions;
    counts[part].cycles += run->cycles;
    before = run;
}

static void on_translate(plugin_id id, struct block *block)
{
    struct run *run = calloc(1, sizeof *run);
    (void)id;
    run->part = -1;
    run->instructions = qemu_plugin_tb_n_insns(block);
    for (size_t i = 0; i < run->instructions; i++) {
        struct insn *insn = qemu_plugin_tb_get_insn(block, i);
        char *text = qemu_plugin_insn_disas(insn);
        run->to = qemu_plugin_insn_vaddr(insn);
        if (i == 0) run->from = run->to;
        run->to += qemu_plugin_insn_size(insn);
        run->cycles += cycles_of(text ? text : "");
        free(text);
    }
    for (int k = 0; k < n_entries; k++)
        if (entries[k].address == run->from) run->part = entries[k].part;
    qemu_plugin_register_vcpu_tb_exec_cb(block, on_execute, 0, run);
}

static void on_finish(plugin_id id, void *data)
{
    FILE *file = fopen("parts.txt", "w");
    (void)id;
    (void)data;
    if (!file) return;
    for (int k = 0; k < PARTS; k++)
        fprintf(file, "%llu %llu\n", (unsigned long long)counts[k].instructions, (unsigned long long)counts[k].cycles);
    fclose(file);
}

/* Arguments: partNUMBER=ADDRESS, both hexadecimal, of each function at which a part begins. Part 0 is from the start on. */
EXPORT int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int k = 0; k < argc; k++) {
        unsigned number;
        unsigned long long address;
        if (n_entries == ENTRIES || sscanf(argv[k], "part%x=%llx", &number, &address) != 2 || number >= PARTS) return 1;
        entries[n_entries].address = address;
        entries[n_entries++].part = (int)number;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translate);
    qemu_plugin_register_atexit_cb(id, on_finish, 0);
    return 0;
}
