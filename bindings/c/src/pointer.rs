//! Pointers from C, checked as far as a pointer can be.

use crate::MwdStatus;

/// Checks that a pointer can lead to a `T`. Outputs are checked before anything is done.
pub fn check<T>(pointer: *const T) -> Result<(), MwdStatus> {
    if pointer.is_null() {
        Err(MwdStatus::ErrorNull)
    } else if !pointer.is_aligned() {
        Err(MwdStatus::ErrorMisaligned)
    } else {
        Ok(())
    }
}

/// Copies a plain struct.
///
/// # Safety
/// A `pointer` that is not NULL leads to a `T`.
pub unsafe fn get<T: Copy>(pointer: *const T) -> Result<T, MwdStatus> {
    check(pointer)?;
    // SAFETY: not null, aligned, and a `T` by the caller's promise.
    Ok(unsafe { pointer.read() })
}

/// Writes a result into memory that may hold nothing yet.
///
/// # Safety
/// A `pointer` that is not NULL leads to memory for a `T`.
pub unsafe fn put<T: Copy>(pointer: *mut T, value: T) -> MwdStatus {
    match check(pointer) {
        Ok(()) => {
            // SAFETY: not null, aligned, and room for a `T` by the caller's promise.
            unsafe { pointer.write(value) };
            MwdStatus::Ok
        }
        Err(status) => status,
    }
}

/// Borrows an object to change it.
///
/// # Safety
/// A `pointer` that is not NULL leads to a `T` that was initialised, and no other call uses it until this one returns.
pub unsafe fn borrow_mut<'a, T>(pointer: *mut T) -> Result<&'a mut T, MwdStatus> {
    check(pointer)?;
    // SAFETY: not null, aligned, initialised and nobody else's by the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// Borrows an object to read it.
///
/// # Safety
/// As of [`borrow_mut`].
pub unsafe fn borrow<'a, T>(pointer: *const T) -> Result<&'a T, MwdStatus> {
    check(pointer)?;
    // SAFETY: not null, aligned and initialised by the caller's promise.
    Ok(unsafe { &*pointer })
}

/// Makes room for an object in the caller's storage and lets `make` build it there.
///
/// # Safety
/// A `storage` that is not NULL leads to `bytes` bytes that nothing else uses; `make` leaves a `T` where it points to.
pub unsafe fn place<T>(
    storage: *mut core::ffi::c_void,
    bytes: usize,
    object: *mut *mut T,
    make: impl FnOnce(*mut T),
) -> MwdStatus {
    let place = storage.cast::<T>();
    if let Err(status) = check(place).and_then(|()| check(object)) {
        return status;
    }
    if bytes < size_of::<T>() {
        return MwdStatus::ErrorTooSmall;
    }
    make(place);
    // SAFETY: not null and aligned, and a pointer to a pointer by the caller's promise.
    unsafe { object.write(place) };
    MwdStatus::Ok
}
