//! Bytes between the loop and the interrupt of a serial port.

use heapless::spsc::{Consumer, Producer, Queue};

/// Bytes that wait for the line: 5 ms of 921,600 baud.
pub type Outgoing = Queue<u8, 512>;
/// Bytes that wait for the loop, which takes a few at each turn: more than the longest command.
pub type Incoming = Queue<u8, 1024>;

/// Main loop's side of the queues.
pub struct SerialQueues {
    pub outgoing: Producer<'static, u8>,
    pub incoming: Consumer<'static, u8>,
}

impl SerialQueues {
    /// Queues as many of the first bytes as there is room for, and returns their number.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        bytes.iter().take_while(|byte| self.outgoing.enqueue(**byte).is_ok()).count()
    }

    pub fn receive(&mut self) -> Option<u8> {
        self.incoming.dequeue()
    }
}
