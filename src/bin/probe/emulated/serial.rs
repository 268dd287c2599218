//! USART1, register by register (the HAL's clock set-up does not end on the emulated chip). The emulated transmitter
//! is always ready: the speed of a real line is kept by counting.

const USART1: usize = 0x4001_1000;
/// Status, data, control 1 (reference manual RM0090, section 30.6).
const SR: *mut u32 = USART1 as *mut u32;
const DR: *mut u32 = (USART1 + 0x04) as *mut u32;
const CR1: *mut u32 = (USART1 + 0x0c) as *mut u32;
const SR_RXNE: u32 = 1 << 5;
const CR1_UE_TE_RE: u32 = 1 << 13 | 1 << 3 | 1 << 2;

/// Bytes that wait for the line at most.
const BUFFER: u64 = 512;

pub struct Serial {
    bytes_per_s: u32,
    /// Bytes given to the line, with those that it could have sent while it had none.
    given: u64,
}

impl Serial {
    pub fn start(bytes_per_s: u32) -> Self {
        write(CR1, CR1_UE_TE_RE);
        Self { bytes_per_s, given: 0 }
    }

    pub fn send(&mut self, bytes: &[u8], now_us: u64) -> usize {
        let sent = now_us * u64::from(self.bytes_per_s) / 1_000_000;
        if self.given < sent {
            self.given = sent;
        }
        let room = BUFFER.saturating_sub(self.given - sent);
        let taken = bytes.len().min(room as usize);
        for byte in bytes.iter().take(taken) {
            write(DR, u32::from(*byte));
        }
        self.given += taken as u64;
        taken
    }

    pub fn receive(&mut self) -> Option<u8> {
        (read(SR) & SR_RXNE != 0).then(|| read(DR) as u8)
    }
}

#[allow(unsafe_code)]
fn write(register: *mut u32, value: u32) {
    // SAFETY: the callers pass registers of USART1, which nobody else uses and which take any word.
    unsafe { register.write_volatile(value) }
}

#[allow(unsafe_code)]
fn read(register: *mut u32) -> u32 {
    // SAFETY: as above; reading the data register takes the byte, and only `receive` does.
    unsafe { register.read_volatile() }
}
