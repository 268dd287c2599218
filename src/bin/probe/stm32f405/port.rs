//! Interrupt of the line's serial port, USART1.

use core::cell::RefCell;
use cortex_m::peripheral::NVIC;
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer};
use stm32f4xx_hal::{
    nb,
    pac::{Interrupt, USART1, interrupt},
    prelude::*,
    serial::{Rx, Serial, Tx},
};

struct Port {
    tx: Tx<USART1>,
    rx: Rx<USART1>,
    outgoing: Consumer<'static, u8>,
    incoming: Producer<'static, u8>,
    /// A byte that the transmitter did not take.
    held: Option<u8>,
}

static PORT: Mutex<RefCell<Option<Port>>> = Mutex::new(RefCell::new(None));

pub fn start(line: Serial<USART1>, outgoing: Consumer<'static, u8>, incoming: Producer<'static, u8>) {
    let (tx, mut rx) = line.split();
    rx.listen();
    let port = Port { tx, rx, outgoing, incoming, held: None };
    critical_section::with(|cs| PORT.borrow(cs).replace(Some(port)));
    // SAFETY: the handler's data stand, and no critical section rests on this interrupt being masked by itself.
    #[allow(unsafe_code)]
    unsafe {
        NVIC::unmask(Interrupt::USART1);
    }
}

/// Starts the interrupt: there is something to send.
pub fn wake() {
    NVIC::pend(Interrupt::USART1);
}

#[interrupt]
fn USART1() {
    static mut MINE: Option<Port> = None;
    if MINE.is_none() {
        *MINE = critical_section::with(|cs| PORT.borrow(cs).take());
    }
    let Some(port) = MINE else { return };
    loop {
        // Without room a command is damaged, and its sender gets no answer.
        let _ = match port.rx.read() {
            Ok(byte) => port.incoming.enqueue(byte),
            // A zero, which ends the frame: a damaged one is of no use.
            Err(nb::Error::Other(_)) => port.incoming.enqueue(0),
            Err(nb::Error::WouldBlock) => break,
        };
    }
    while let Some(byte) = port.held.take().or_else(|| port.outgoing.dequeue()) {
        if port.tx.write(byte).is_err() {
            port.held = Some(byte);
            port.tx.listen();
            return;
        }
    }
    port.tx.unlisten();
}
