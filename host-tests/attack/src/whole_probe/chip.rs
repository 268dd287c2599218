//! Parts of a chip that go on whatever the program does: time, power, flash and watchdog.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use mock_flash::{MockError, MockFlash};
use std::cell::{Cell, RefCell};

/// Sector of the flash, bytes: the smallest that there may be, so that sectors are filled and erased often.
pub const SECTOR: usize = 8 * 1024;
pub const SECTORS: usize = 3;
pub type Flash = MockFlash<4, SECTOR>;

/// Patience of the watchdog, microseconds: the fastest of a real board.
pub const PATIENCE_US: u64 = 1_000_000;
/// Time to program a word and to erase a sector of 8 KiB, microseconds (DS8626, flash memory programming, typical).
const WORD_US: u64 = 16;
const ERASE_US: u64 = 250_000;
/// Magic number and kind in the head of a counter's record, behind its check (`src/storage/record.rs`).
const COUNTER: [u8; 3] = *b"MW\x02";

/// End of the program's run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Death {
    /// The power failed.
    PowerCut,
    /// The watchdog was not fed.
    Watchdog,
}

/// The chip. Its time goes on from power-up to power-up.
pub struct Chip {
    pub now_us: Cell<u64>,
    /// Time of the last power-up or reset.
    pub started_us: Cell<u64>,
    pub fed_us: Cell<u64>,
    pub death: Cell<Option<Death>>,
    pub flash: RefCell<Flash>,
    /// The flash as it would be if the write had come to its end in which the power failed.
    pub whole: RefCell<Option<Flash>>,
    /// Where the latest copy of the counter of commands was written.
    pub counter_at: Cell<Option<usize>>,
    /// Times of erasures since the last power-up.
    pub erased_us: RefCell<Vec<u64>>,
    /// Address of the stack where the program was called, and the lowest at which it called its board.
    stack: Cell<[usize; 2]>,
}

/// Address of the stack here.
#[inline(never)]
fn stack_address() -> usize {
    let here = 0_u8;
    std::ptr::from_ref(std::hint::black_box(&here)).addr()
}

impl Chip {
    pub fn new(flash: Flash) -> Self {
        Self {
            now_us: Cell::new(0),
            started_us: Cell::new(0),
            fed_us: Cell::new(0),
            death: Cell::new(None),
            flash: RefCell::new(flash),
            whole: RefCell::new(None),
            counter_at: Cell::new(None),
            erased_us: RefCell::default(),
            stack: Cell::new([0; 2]),
        }
    }

    /// The program is called from here.
    pub fn call_from_here(&self) {
        self.stack.set([stack_address(); 2]);
    }

    /// The program has called its board.
    pub fn note_stack(&self) {
        let [from, lowest] = self.stack.get();
        self.stack.set([from, lowest.min(stack_address())]);
    }

    /// Bytes of stack that the program had taken at the deepest call of its board.
    pub fn stack_bytes(&self) -> u64 {
        let [from, lowest] = self.stack.get();
        (from - lowest) as u64
    }

    pub fn is_dead(&self) -> bool {
        self.death.get().is_some()
    }

    /// The program's end; nothing that it still does has an effect.
    pub fn die(&self, death: Death) {
        if !self.is_dead() {
            self.death.set(Some(death));
        }
    }

    /// Power comes, or the program starts again.
    pub fn start(&self) {
        self.death.set(None);
        self.flash.borrow_mut().power_up();
        self.started_us.set(self.now_us.get());
        self.fed_us.set(self.now_us.get());
        self.erased_us.borrow_mut().clear();
        self.whole.replace(None);
    }

    /// Time passes while the program computes or waits.
    pub fn pass(&self, us: u64) {
        self.now_us.set(self.now_us.get() + us);
        if self.now_us.get() - self.fed_us.get() > PATIENCE_US {
            self.die(Death::Watchdog);
        }
    }

    pub fn feed(&self) {
        if !self.is_dead() {
            self.fed_us.set(self.now_us.get());
        }
    }

    fn done<T>(&self, result: Result<T, MockError>) -> Result<T, MockError> {
        if matches!(result, Err(MockError::PowerCut)) {
            self.die(Death::PowerCut);
        }
        result
    }

    fn alive(&self) -> Result<(), MockError> {
        self.note_stack();
        if self.is_dead() { Err(MockError::PowerCut) } else { Ok(()) }
    }
}

/// The program's access to the flash.
#[derive(Clone, Copy)]
pub struct ChipFlash<'c>(pub &'c Chip);

impl ErrorType for ChipFlash<'_> {
    type Error = MockError;
}

impl ReadNorFlash for ChipFlash<'_> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MockError> {
        self.0.alive()?;
        self.0.flash.borrow_mut().read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR
    }
}

impl NorFlash for ChipFlash<'_> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), MockError> {
        self.0.alive()?;
        self.0.erased_us.borrow_mut().push(self.0.now_us.get());
        self.0.pass(ERASE_US * u64::from(to.saturating_sub(from)) / SECTOR as u64);
        let result = self.0.flash.borrow_mut().erase(from, to);
        self.0.done(result)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), MockError> {
        self.0.alive()?;
        self.0.pass(WORD_US * (bytes.len() / 4) as u64);
        if bytes.get(4..7) == Some(&COUNTER) {
            self.0.counter_at.set(Some(offset as usize));
        }
        let result = self.0.flash.borrow_mut().write(offset, bytes);
        if matches!(result, Err(MockError::PowerCut)) {
            let mut whole = self.0.flash.borrow().clone();
            whole.put(offset as usize, bytes);
            self.0.whole.replace(Some(whole));
        }
        self.0.done(result)
    }
}
