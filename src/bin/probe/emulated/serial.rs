//! Serial line, register by register (the HAL's clock set-up does not end on the emulated chip). The emulated
//! transmitter takes bytes at once: the speed of a real line is kept by counting.

/// USART1 of the STM32F405.
#[cfg(not(feature = "board-updatable"))]
mod device {
    use super::{read, write};

    const USART1: usize = 0x4001_1000;
    /// Status, data, control 1 (reference manual RM0090, section 30.6).
    const SR: *mut u32 = USART1 as *mut u32;
    const DR: *mut u32 = (USART1 + 0x04) as *mut u32;
    const CR1: *mut u32 = (USART1 + 0x0c) as *mut u32;
    const SR_RXNE: u32 = 1 << 5;
    const CR1_UE_TE_RE: u32 = 1 << 13 | 1 << 3 | 1 << 2;

    pub fn start() {
        write(CR1, CR1_UE_TE_RE);
    }

    pub const fn has_room() -> bool {
        true
    }

    pub fn put(byte: u8) {
        write(DR, u32::from(byte));
    }

    pub fn take() -> Option<u8> {
        (read(SR) & SR_RXNE != 0).then(|| read(DR) as u8)
    }
}

/// UART 0 of the MPS2, a CMSDK APB UART.
#[cfg(feature = "board-updatable")]
mod device {
    use super::{read, write};

    const UART0: usize = 0x4000_4000;
    /// Data, state, control, divider of the clock (Arm Cortex-M System Design Kit TRM, DDI 0479, section 4.3).
    const DATA: *mut u32 = UART0 as *mut u32;
    const STATE: *mut u32 = (UART0 + 0x04) as *mut u32;
    const CTRL: *mut u32 = (UART0 + 0x08) as *mut u32;
    const BAUDDIV: *mut u32 = (UART0 + 0x10) as *mut u32;
    const STATE_TX_FULL: u32 = 1;
    const STATE_RX_FULL: u32 = 1 << 1;
    const CTRL_TX_RX: u32 = 1 | 1 << 1;
    /// 25 MHz over 921,600 baud.
    const DIVIDER: u32 = 27;

    pub fn start() {
        write(BAUDDIV, DIVIDER);
        write(CTRL, CTRL_TX_RX);
    }

    pub fn has_room() -> bool {
        read(STATE) & STATE_TX_FULL == 0
    }

    pub fn put(byte: u8) {
        write(DATA, u32::from(byte));
    }

    pub fn take() -> Option<u8> {
        (read(STATE) & STATE_RX_FULL != 0).then(|| read(DATA) as u8)
    }
}

/// Bytes that wait for the line at most.
const BUFFER: u64 = 512;

pub struct Serial {
    bytes_per_s: u32,
    /// Bytes given to the line, with those that it could have sent while it had none.
    given: u64,
    /// True if a byte has come since [`Serial::take_activity`] was called.
    came: bool,
}

impl Serial {
    pub fn start(bytes_per_s: u32) -> Self {
        device::start();
        Self { bytes_per_s, given: 0, came: false }
    }

    pub fn send(&mut self, bytes: &[u8], now_us: u64) -> usize {
        let sent = now_us * u64::from(self.bytes_per_s) / 1_000_000;
        if self.given < sent {
            self.given = sent;
        }
        let room = BUFFER.saturating_sub(self.given - sent);
        let mut taken = 0;
        for byte in bytes.iter().take(bytes.len().min(room as usize)) {
            if !device::has_room() {
                break;
            }
            device::put(*byte);
            taken += 1;
        }
        self.given += taken as u64;
        taken
    }

    pub fn receive(&mut self) -> Option<u8> {
        let byte = device::take();
        self.came |= byte.is_some();
        byte
    }

    /// Returns true if a byte has come since the last call: the emulator gives one at a time, and more may follow at
    /// once.
    pub const fn take_activity(&mut self) -> bool {
        core::mem::replace(&mut self.came, false)
    }
}

#[allow(unsafe_code)]
fn write(register: *mut u32, value: u32) {
    // SAFETY: the callers pass registers of the serial line, which nobody else uses and which take any word.
    unsafe { register.write_volatile(value) }
}

#[allow(unsafe_code)]
fn read(register: *mut u32) -> u32 {
    // SAFETY: as above; reading the data register takes the byte, and only `receive` does.
    unsafe { register.read_volatile() }
}
