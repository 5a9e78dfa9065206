//! The boards; a build is for one of them.

#[cfg(feature = "feather-f405")]
pub mod feather_f405;
#[cfg(feature = "mps2-an386")]
pub mod mps2_an386;

#[cfg(feature = "board")]
mod hard_fault {
    #[cfg(feature = "feather-f405")]
    use super::feather_f405::end::fault;
    #[cfg(feature = "mps2-an386")]
    use super::mps2_an386::end::fault;

    /// Entered on a stack overflow too, when there is no stack to speak of:
    /// starts the stack anew before any code that needs one.
    // SAFETY: the name is the one by which cortex-m-rt's vector table calls it,
    // as an exception handler; it never returns, so what it does to the stack
    // is nobody's loss.
    #[unsafe(naked)]
    #[unsafe(no_mangle)]
    unsafe extern "C" fn HardFault() -> ! {
        core::arch::naked_asm!(
            "ldr r0, =_stack_start",
            "mov sp, r0",
            "b {fault}",
            fault = sym fault,
        )
    }
}
