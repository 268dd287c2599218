use super::*;

#[test]
fn a_fault_acts_from_its_transaction_for_its_time() {
    let fault = PartFault::FrozenOutput;
    let mut schedule = Schedule::of(Injection { fault, at_transaction: 1, lasting_us: 500 });
    assert_eq!((schedule.begin(0), schedule.acting(0)), (None, None));
    assert_eq!((schedule.begin(100), schedule.acting(100)), (Some(fault), Some(fault)));
    assert_eq!((schedule.begin(599), schedule.acting(599)), (None, Some(fault)));
    assert_eq!(schedule.acting(600), None);

    let mut schedule = Schedule::of(Injection { fault, at_transaction: 0, lasting_us: 0 });
    assert_eq!((schedule.begin(700), schedule.acting(700)), (Some(fault), Some(fault)));
    assert_eq!((schedule.begin(700), schedule.acting(700)), (None, None));
}
