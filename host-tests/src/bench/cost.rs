//! Cost of a flight on the emulated chip: cycles beside instructions, and what bounds them.

use crate::target::{
    call_costs::{Call, CallCosts, Cost, count_calls},
    firmware::{Board, build_firmware},
    image::Image,
    toolchain,
};
use meerkat_mwd::{Config, Sample};
use testbed::study::{Cell, Effort, Table, one_window::scenario};
use testbed::{
    flight::configuration::of_trace,
    simulate::simulate,
    trace::{Trace, recordings},
};

/// Length of a simulated run, seconds: one window, its latency and some more.
const DURATION_S: f64 = 60.0;
/// Sample periods of the simulated runs, microseconds.
const USUAL_US: u32 = 10_000;
const FAST_US: u32 = 5_000;
/// Clock of the slowest chip that is to do, Hz.
const SLOW_CLOCK_HZ: f64 = 64e6;
/// Recording of a hand-held probe.
const BY_HAND: &str = "broad_06_fast_rotation_110s";

/// One run: its name, and what its calls cost.
struct Run {
    name: &'static str,
    seconds: f64,
    costs: CallCosts,
}

/// Runs once, whatever the effort: the emulator counts exactly.
pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let runs = [
        drilling("drilling_vertical", "vertical", USUAL_US)?,
        drilling("drilling_45deg", "45 deg", USUAL_US)?,
        drilling("drilling_45deg", "45 deg, 200 Hz", FAST_US)?,
        by_hand()?,
    ];
    Ok(vec![most(&runs), tasks(&runs), bounds(&runs), memory()?])
}

fn drilling(scenario_name: &str, name: &'static str, period_us: u32) -> anyhow::Result<Run> {
    let mut scenario = scenario(scenario_name)?;
    (scenario.duration_s, scenario.sample_period_us) = (DURATION_S, period_us);
    let (trace, _) = simulate(&scenario, 1);
    fly(name, &of_trace(&trace), &trace.samples)
}

fn by_hand() -> anyhow::Result<Run> {
    let path = recordings::bundled()?.into_iter().find(|path| recordings::name(path) == BY_HAND);
    let trace = Trace::read(&path.ok_or_else(|| anyhow::anyhow!("{BY_HAND} is not bundled"))?)?;
    fly("by hand, 286 Hz", &of_trace(&trace), &trace.samples)
}

fn fly(name: &'static str, config: &Config, samples: &[Sample]) -> anyhow::Result<Run> {
    let seconds = samples.len() as f64 * f64::from(config.sample_period_us) * 1e-6;
    Ok(Run { name, seconds, costs: count_calls(config, samples)? })
}

/// Whole tasks of each run, with the bound that each is held to.
fn most(runs: &[Run]) -> Table {
    let names = runs.iter().map(|run| run.name);
    let columns: Vec<&str> = [""].into_iter().chain(names).chain(["at most"]).collect();
    let mut table = Table::new(
        "Thousands of cycles, and of instructions, on the emulated Cortex-M4F (STM32F405, QEMU); cycles are estimated from the processor's \
         instruction timings with memory that never waits",
        &columns,
    );
    let mut row = |name: &str, of: &dyn Fn(&CallCosts) -> Cost, bound: &str| {
        let cells = runs.iter().map(|run| {
            let cost = of(&run.costs);
            Cell::from(format!("{:.1}; {:.1}", cost.cycles as f64 / 1e3, cost.instructions as f64 / 1e3))
        });
        table.row([Cell::from(name)].into_iter().chain(cells).chain([Cell::from(bound)]));
    };
    row("all work beside samples to a report, worst", &|costs| costs.of(Call::Work).most_of_period, "30,000");
    row("a node, worst", &|costs| costs.of(Call::Node).most_of_period, "250");
    row("its longest slice", &|costs| costs.of(Call::Node).most, "12");
    row("longest piece of the filter", &|costs| costs.of(Call::Piece).most, "");
    row("longest piece of the search", &|costs| costs.of(Call::Searching).most, "");
    row("judgement of an update", &|costs| costs.of(Call::Judging).most, "");
    row("a sample, mean", &|costs| mean(costs.of(Call::Sample).sum, costs.of(Call::Sample).count), "5");
    row("a sample, worst", &|costs| costs.of(Call::Sample).most, "25");
    let shares = runs.iter().map(|run| {
        let both = run.costs.of(Call::Sample).sum.cycles + run.costs.of(Call::Work).sum.cycles;
        Cell::percent(both as f64 / run.seconds / SLOW_CLOCK_HZ, 1)
    });
    table.row([Cell::from("steady state, % of 64 MHz")].into_iter().chain(shares).chain([Cell::from("6 at 200 Hz")]));
    table
}

fn mean(sum: Cost, count: u64) -> Cost {
    let of = |sum: u64| sum.checked_div(count).unwrap_or(0);
    Cost {
        instructions: of(sum.instructions),
        cycles: of(sum.cycles),
        products: of(sum.products),
        arithmetic: of(sum.arithmetic),
        memory: of(sum.memory),
    }
}

/// Tasks of the work beside samples, by the calls that do them. An increment's calls contain those of the rows of a
/// node that ends with it.
const TASKS: [(&str, Call, Option<Call>); 10] = [
    ("increments, with the effects' terms", Call::Increment, Some(Call::Rows)),
    ("a node's rows", Call::Rows, None),
    ("elimination of its states", Call::Eliminating, None),
    ("its way into the globals", Call::Absorbing, None),
    ("its way into the effects' rows", Call::AbsorbingOwn, None),
    ("walks", Call::Walking, None),
    ("averages over widths", Call::Averaging, None),
    ("bounds of the search", Call::Bounding, None),
    ("search", Call::Searching, None),
    ("weighing of effects", Call::Weighing, None),
];

/// Where the cycles of the work beside samples go, with what a product and its sum take at best.
fn tasks(runs: &[Run]) -> Table {
    let names = runs.iter().map(|run| run.name);
    let columns: Vec<&str> = [""].into_iter().chain(names).collect();
    let mut table = Table::new(
        "Where the cycles of the work beside samples go, a second of flight, in thousands: all; what their products of floats, each \
         with its sum, take at two cycles; what these and the loads and stores take",
        &columns,
    );
    let mut row = |name: &str, of: &dyn Fn(&CallCosts) -> [u64; 3]| {
        let cells = runs.iter().map(|run| {
            let [cycles, products, bound] = of(&run.costs).map(|sum| sum as f64 / run.seconds / 1e3);
            Cell::from(format!("{cycles:.0}; {products:.0}; {bound:.0}"))
        });
        table.row([Cell::from(name)].into_iter().chain(cells));
    };
    let figures = |cost: Cost| [cost.cycles, 2 * cost.products, 2 * cost.products + cost.memory];
    let less =
        |[a, b, c]: [u64; 3], [x, y, z]: [u64; 3]| [a.saturating_sub(x), b.saturating_sub(y), c.saturating_sub(z)];
    let of_task = |costs: &CallCosts, call: Call, within: Option<Call>| {
        let all = figures(costs.of(call).sum);
        within.map_or(all, |within| less(all, figures(costs.of(within).sum)))
    };
    for (name, call, within) in TASKS {
        row(name, &|costs| of_task(costs, call, within));
    }
    row("all else: judgements, questions, calls", &|costs| {
        let all = figures(costs.of(Call::Work).sum);
        TASKS.iter().fold(all, |rest, (_, call, within)| less(rest, of_task(costs, *call, *within)))
    });
    row("all", &|costs| figures(costs.of(Call::Work).sum));
    table
}

/// Bounds of each kind of work. Two cycles a product: the processor's sum of products takes three, its product and its
/// sum one each.
fn bounds(runs: &[Run]) -> Table {
    let mut table = Table::new(
        "What bounds them, all calls of a run together: products of floats, each with its sum two cycles at best; shares of the cycles. \
         A node is bound by its reflections: a column of nine rows and two pivots takes 38 products in 76 cycles, eleven loads and \
         eleven stores in 44, and 13 of its loop, 3.5 cycles a product; the rest of a node's are short of so many rows. Other work \
         has few products for each load. A sample has no kernel: none of its parts takes a twelfth of it",
        &["", "", "M products", "M cycles", "cycles a product", "arithmetic, %", "loads and stores, %", "the rest, %"],
    );
    for run in runs {
        for (name, call) in [("samples", Call::Sample), ("nodes", Call::Node), ("all work beside samples", Call::Work)]
        {
            let Cost { cycles, products, arithmetic, memory, .. } = run.costs.of(call).sum;
            let share = |part: u64| Cell::percent(part as f64 / cycles as f64, 0);
            table.row([
                Cell::from(run.name),
                Cell::from(name),
                Cell::number(products as f64 / 1e6, 2),
                Cell::number(cycles as f64 / 1e6, 2),
                Cell::number(cycles as f64 / products as f64, 1),
                share(arithmetic),
                share(memory),
                share(cycles.saturating_sub(arithmetic + memory)),
            ]);
        }
    }
    table
}

/// Memory of the pipeline with nothing around it.
fn memory() -> anyhow::Result<Table> {
    let firmware = build_firmware(&toolchain::prepare()?, Board::Bare)?;
    let probe = Image::parse(&firmware.elf)?.data_of("PROBE").unwrap_or(0);
    let mut table = Table::new("Memory, KiB", &["", "", "at most"]);
    let kib = |bytes: u64| Cell::number(bytes as f64 / 1024.0, 1);
    table.row([Cell::from("RAM of a full probe"), kib(probe), Cell::from("64")]);
    table.row([Cell::from("flash of its calls, and of surveys"), kib(firmware.size.flash_bytes), Cell::from("256")]);
    Ok(table)
}
