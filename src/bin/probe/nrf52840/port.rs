//! Interrupt of the line's serial port, UART0, byte by byte (the same port by DMA, UARTE0, would need its buffers
//! waited for).

use core::cell::RefCell;
use cortex_m::peripheral::NVIC;
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer};
use nrf52840_hal::{
    gpio::{Floating, Input, Output, Pin, PushPull},
    pac::{Interrupt, UART0, interrupt},
};

struct Port {
    uart: UART0,
    outgoing: Consumer<'static, u8>,
    incoming: Producer<'static, u8>,
    /// A byte is on the line.
    sending: bool,
}

static PORT: Mutex<RefCell<Option<Port>>> = Mutex::new(RefCell::new(None));

pub fn start(
    uart: UART0,
    (tx, rx): (Pin<Output<PushPull>>, Pin<Input<Floating>>),
    outgoing: Consumer<'static, u8>,
    incoming: Producer<'static, u8>,
) {
    // SAFETY: the numbers are those of pins that this function was given.
    #[allow(unsafe_code)]
    unsafe {
        uart.psel.txd.write(|w| w.bits(tx.psel_bits()));
        uart.psel.rxd.write(|w| w.bits(rx.psel_bits()));
    }
    uart.baudrate.write(|w| w.baudrate().baud921600());
    uart.enable.write(|w| w.enable().enabled());
    uart.intenset.write(|w| {
        w.rxdrdy().set();
        w.txdrdy().set()
    });
    uart.tasks_starttx.write(|w| w.tasks_starttx().set_bit());
    uart.tasks_startrx.write(|w| w.tasks_startrx().set_bit());
    let port = Port { uart, outgoing, incoming, sending: false };
    critical_section::with(|cs| PORT.borrow(cs).replace(Some(port)));
    // SAFETY: the handler's data stand, and no critical section rests on this interrupt being masked by itself.
    #[allow(unsafe_code)]
    unsafe {
        NVIC::unmask(Interrupt::UARTE0_UART0);
    }
}

/// Starts the interrupt: there is something to send.
pub fn wake() {
    NVIC::pend(Interrupt::UARTE0_UART0);
}

#[interrupt]
fn UARTE0_UART0() {
    static mut MINE: Option<Port> = None;
    if MINE.is_none() {
        *MINE = critical_section::with(|cs| PORT.borrow(cs).take());
    }
    let Some(port) = MINE else { return };
    while port.uart.events_rxdrdy.read().bits() != 0 {
        port.uart.events_rxdrdy.reset();
        // A byte with an error is passed on: the frame's check notices it. Without room a command is damaged, and its
        // sender gets no answer.
        let _ = port.incoming.enqueue(port.uart.rxd.read().rxd().bits());
    }
    if port.uart.events_txdrdy.read().bits() != 0 {
        port.uart.events_txdrdy.reset();
        port.sending = false;
    }
    if !port.sending
        && let Some(byte) = port.outgoing.dequeue()
    {
        port.sending = true;
        // SAFETY: the field takes any byte.
        #[allow(unsafe_code)]
        port.uart.txd.write(|w| unsafe { w.txd().bits(byte) });
    }
}
