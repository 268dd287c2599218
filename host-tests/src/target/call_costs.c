/* A plugin of QEMU's that counts executed instructions and estimates Cortex-M4F cycles, call by call of a program's
 * functions.
 *
 * A call lasts from a function's first instruction to the one behind the call, with all that it calls. Debian ships no
 * header of the interface, so what is needed of it is declared here. PVER is the version of the interface: 1 for QEMU 7
 * and 8, 4 for 10.
 *
 * Cycles: Arm's Cortex-M4 Technical Reference Manual (r0p1, tables 3-1 and 7-1) with memory that never waits; VSQRT
 * taken as VDIV; loads are not pipelined; a taken branch adds 2. A board's flash adds waits of its own, which only a
 * board can count.
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
extern size_t qemu_plugin_tb_n_insns(const struct block *);
extern struct insn *qemu_plugin_tb_get_insn(const struct block *, size_t);
extern uint64_t qemu_plugin_insn_vaddr(const struct insn *);
extern char *qemu_plugin_insn_disas(const struct insn *);
extern size_t qemu_plugin_insn_size(const struct insn *);

enum { KINDS = 32, ENTRIES = 128 };

/* Counts: instructions, cycles, products of floats, cycles of float arithmetic, cycles of loads and stores. */
enum { INSTRUCTIONS, CYCLES, PRODUCTS, ARITHMETIC, MEMORY, COUNTS };

/* A run of code without a branch, whether it ends with a call, the kinds of call that begin with it, and those whose
 * period does. */
struct run { uint64_t from, to, counts[COUNTS]; int calls; uint32_t begins, ends_period; };
static struct { uint64_t address; int kind, is_period; } entries[ENTRIES];
static int n_entries, n_kinds;
static uint64_t now[COUNTS];
static const struct run *before;
/* Where the latest call returns to: an interrupt may come between a call and the function's first instruction. */
static uint64_t returns_to;

/* Calls of a kind: where the present one returns to, and what stood in the counts at its beginning; calls in all, their
 * sums, the dearest; the same of a period, which is all calls from one function's entry to its next. */
static struct {
    uint64_t returns, at[COUNTS], calls, sum[COUNTS], most[COUNTS];
    uint64_t periods, in_period[COUNTS], most_of_period[COUNTS];
    int is_in;
} kinds[KINDS];

static int starts(const char *text, const char *prefix) { return !strncmp(text, prefix, strlen(prefix)); }

static int registers_in_list(const char *text)
{
    const char *p = strchr(text, '{');
    int n = 1;
    for (; p && *p && *p != '}'; p++) n += *p == ',';
    return n;
}

/* Cycles of an instruction that loads or stores; else 0. */
static int memory_cycles(const char *text)
{
    if (starts(text, "vldr") || starts(text, "vstr")) return strstr(text, " d") ? 3 : 2;
    if (starts(text, "vldm") || starts(text, "vstm") || starts(text, "vpush") || starts(text, "vpop"))
        return 1 + registers_in_list(text) * (strstr(text, "{d") ? 2 : 1);
    if (starts(text, "ldm") || starts(text, "stm") || starts(text, "push") || starts(text, "pop")) return 1 + registers_in_list(text);
    if (starts(text, "ldrd") || starts(text, "strd")) return 3;
    if (starts(text, "ldr") || starts(text, "str")) return 2;
    return 0;
}

static int multiplies_and_adds(const char *text)
{
    return starts(text, "vmla") || starts(text, "vmls") || starts(text, "vnml") || starts(text, "vfm") || starts(text, "vfnm");
}

/* Cycles of arithmetic of floats; else 0. */
static int arithmetic_cycles(const char *text)
{
    if (text[0] != 'v') return 0;
    if (starts(text, "vdiv") || starts(text, "vsqrt")) return 14;
    return multiplies_and_adds(text) ? 3 : 1;
}

/* Calls, and not the branches ble, bls and blt. */
static int is_call(const char *text) { return starts(text, "bl ") || starts(text, "bl\t") || starts(text, "blx"); }

static void count(struct run *run, const char *text)
{
    int memory = memory_cycles(text), arithmetic = memory ? 0 : arithmetic_cycles(text);
    int other = starts(text, "sdiv") || starts(text, "udiv") ? 7 : 1;
    run->counts[INSTRUCTIONS]++;
    run->counts[CYCLES] += memory ? memory : arithmetic ? arithmetic : other;
    run->counts[PRODUCTS] += multiplies_and_adds(text) || starts(text, "vmul") || starts(text, "vnmul");
    run->counts[ARITHMETIC] += arithmetic;
    run->counts[MEMORY] += memory;
    run->calls = is_call(text);
}

static void end_call(int k)
{
    uint64_t cost[COUNTS];
    for (int i = 0; i < COUNTS; i++) cost[i] = now[i] - kinds[k].at[i];
    for (int i = 0; i < COUNTS; i++) kinds[k].sum[i] += cost[i], kinds[k].in_period[i] += cost[i];
    if (cost[CYCLES] > kinds[k].most[CYCLES]) memcpy(kinds[k].most, cost, sizeof cost);
    kinds[k].calls++;
    kinds[k].is_in = 0;
}

static void end_period(int k)
{
    if (kinds[k].in_period[CYCLES] > kinds[k].most_of_period[CYCLES])
        memcpy(kinds[k].most_of_period, kinds[k].in_period, sizeof kinds[k].in_period);
    memset(kinds[k].in_period, 0, sizeof kinds[k].in_period);
    kinds[k].periods++;
}

static void on_execute(unsigned cpu, void *data)
{
    const struct run *run = data;
    (void)cpu;
    if (before && run->from != before->to) now[CYCLES] += 2;
    if (before && before->calls) returns_to = before->to;
    for (int k = 0; k < n_kinds; k++) {
        if (kinds[k].is_in && run->from == kinds[k].returns) end_call(k);
        if (run->ends_period >> k & 1) end_period(k);
        if (run->begins >> k & 1 && !kinds[k].is_in && before) {
            kinds[k].is_in = 1;
            kinds[k].returns = returns_to;
            memcpy(kinds[k].at, now, sizeof now);
        }
    }
    for (int i = 0; i < COUNTS; i++) now[i] += run->counts[i];
    before = run;
}

static void on_translate(plugin_id id, struct block *block)
{
    struct run *run = calloc(1, sizeof *run);
    size_t size = qemu_plugin_tb_n_insns(block);
    (void)id;
    for (size_t i = 0; i < size; i++) {
        struct insn *insn = qemu_plugin_tb_get_insn(block, i);
        char *text = qemu_plugin_insn_disas(insn);
        run->to = qemu_plugin_insn_vaddr(insn);
        if (i == 0) run->from = run->to;
        run->to += qemu_plugin_insn_size(insn);
        count(run, text ? text : "");
        free(text);
    }
    for (int k = 0; k < n_entries; k++) {
        uint32_t bit = entries[k].address == run->from ? (uint32_t)1 << entries[k].kind : 0;
        if (entries[k].is_period) run->ends_period |= bit; else run->begins |= bit;
    }
    qemu_plugin_register_vcpu_tb_exec_cb(block, on_execute, 0, run);
}

static void print(FILE *file, const uint64_t *counts)
{
    for (int i = 0; i < COUNTS; i++) fprintf(file, " %llu", (unsigned long long)counts[i]);
}

static void on_finish(plugin_id id, void *data)
{
    FILE *file = fopen("costs.txt", "w");
    (void)id;
    (void)data;
    if (!file) return;
    for (int k = 0; k < n_kinds; k++) {
        fprintf(file, "%llu", (unsigned long long)kinds[k].calls);
        print(file, kinds[k].sum);
        print(file, kinds[k].most);
        fprintf(file, " %llu", (unsigned long long)kinds[k].periods);
        print(file, kinds[k].most_of_period);
        fprintf(file, "\n");
    }
    fclose(file);
}

/* Arguments: callNUMBER=ADDRESS of each function of a kind of call, and periodNUMBER=ADDRESS of the function at which a
 * period ends. All are hexadecimal. */
EXPORT int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int k = 0; k < argc; k++) {
        unsigned number;
        unsigned long long address;
        int is_period = starts(argv[k], "period");
        const char *format = is_period ? "period%x=%llx" : "call%x=%llx";
        if (n_entries == ENTRIES || sscanf(argv[k], format, &number, &address) != 2 || number >= KINDS) return 1;
        entries[n_entries].address = address;
        entries[n_entries].is_period = is_period;
        entries[n_entries++].kind = (int)number;
        if ((int)number >= n_kinds) n_kinds = (int)number + 1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translate);
    qemu_plugin_register_atexit_cb(id, on_finish, 0);
    return 0;
}
