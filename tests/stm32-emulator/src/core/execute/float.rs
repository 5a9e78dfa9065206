//! Floating-point instructions on registers, and whether the unit may be used.
//! Source: DDI 0403, A2.5, A7.7 (VADD and so on) and B1.5.7 (`ExecuteFPCheck`).

use super::super::Core;
use super::super::arithmetic::Flags;
use super::super::fault::Fault;
use super::super::float::{self, SIGN, fpscr};
use super::super::instruction::{Convert, FloatOp, Instruction, Reg};
use super::super::registers::control;
use super::super::system_control::fpccr;
use super::Outcome;
use crate::memory::Memory;

/// Bits of FPSCR that a new context takes from FPDSCR.
const DEFAULTS: u32 = 0x07C0_0000;

impl Core {
    /// Makes the unit ready for an instruction: access, context, lazily kept state.
    #[inline]
    pub(super) fn use_float<M: Memory>(&mut self, memory: &mut M) -> Result<(), Fault> {
        if self.float_ready {
            return Ok(());
        }
        self.prepare_float(memory)
    }

    #[inline(never)]
    fn prepare_float<M: Memory>(&mut self, memory: &mut M) -> Result<(), Fault> {
        let allowed = match self.control.cpacr >> 20 & 3 {
            3 => true,
            1 => self.is_privileged(),
            _ => false,
        };
        if !allowed {
            return Err(Fault::NoCoprocessor);
        }
        if self.control.fpccr & fpccr::LSPACT != 0 {
            self.preserve_float(memory);
        }
        let automatic = self.control.fpccr & fpccr::ASPEN != 0;
        if automatic && self.special & control::FLOAT_ACTIVE == 0 {
            self.fpscr = self.fpscr & !DEFAULTS | self.control.fpdscr & DEFAULTS;
            self.special |= control::FLOAT_ACTIVE;
        }
        self.float_ready = true;
        Ok(())
    }

    /// A cycle if the register is the result of the arithmetic just before.
    #[inline]
    pub(super) fn wait_for(&self, register: Reg) -> u32 {
        u32::from(self.float_result == (self.executed, register))
    }

    #[inline]
    fn single(&self, register: Reg) -> u32 {
        self.s[usize::from(register & 31)]
    }

    #[inline]
    fn put_single(&mut self, register: Reg, bits: u32) {
        self.s[usize::from(register & 31)] = bits;
    }

    #[inline]
    pub(super) fn float_operate<M: Memory>(
        &mut self,
        memory: &mut M,
        op: FloatOp,
        d: Reg,
        n: Reg,
        m: Reg,
    ) -> Outcome {
        self.use_float(memory)?;
        let (x, y, z) = (self.single(n), self.single(m), self.single(d));
        let wait = self.wait_for(m) | self.wait_for(n);
        let status = &mut self.fpscr;
        let result = match op {
            FloatOp::Add => float::add(status, x, y),
            FloatOp::Subtract => float::subtract(status, x, y),
            FloatOp::Multiply => float::multiply(status, x, y),
            FloatOp::NegatedMultiply => float::multiply(status, x, y) ^ SIGN,
            FloatOp::Divide => float::divide(status, x, y),
            FloatOp::Root => float::root(status, y),
            FloatOp::MultiplyAdd => {
                let product = float::multiply(status, x, y);
                float::add(status, z, product)
            }
            FloatOp::MultiplySubtract => {
                let product = float::multiply(status, x, y);
                float::add(status, z, product ^ SIGN)
            }
            FloatOp::NegatedMultiplyAdd => {
                let product = float::multiply(status, x, y);
                float::add(status, z ^ SIGN, product ^ SIGN)
            }
            FloatOp::NegatedMultiplySubtract => {
                let product = float::multiply(status, x, y);
                float::add(status, z ^ SIGN, product)
            }
            FloatOp::Fused => float::multiply_add(status, z, x, y),
            FloatOp::FusedSubtract => float::multiply_add(status, z, x ^ SIGN, y),
            FloatOp::NegatedFused => float::multiply_add(status, z ^ SIGN, x ^ SIGN, y),
            FloatOp::NegatedFusedSubtract => float::multiply_add(status, z ^ SIGN, x, y),
            FloatOp::Move => y,
            FloatOp::Absolute => y & !SIGN,
            FloatOp::Negate => y ^ SIGN,
        };
        self.put_single(d, result);
        if !matches!(op, FloatOp::Move | FloatOp::Absolute | FloatOp::Negate) {
            self.float_result = (self.executed + 1, d);
        }
        Ok(wait)
    }

    /// The less frequent instructions of the unit.
    pub(super) fn execute_float<M: Memory>(
        &mut self,
        memory: &mut M,
        instruction: Instruction,
    ) -> Outcome {
        self.use_float(memory)?;
        match instruction {
            Instruction::FloatImmediate { d, bits } => self.put_single(d, bits),
            Instruction::FloatCompare {
                d,
                m,
                with_zero,
                signal,
            } => {
                let wait = self.wait_for(d) | self.wait_for(m);
                let y = if with_zero { 0 } else { self.single(m) };
                let x = self.single(d);
                let flags = float::compare(&mut self.fpscr, x, y, signal);
                self.fpscr = self.fpscr & 0x0FFF_FFFF | flags << 28;
                return Ok(wait);
            }
            Instruction::FloatConvert { op, d, m } => {
                let wait = self.wait_for(m);
                let result = self.convert(op, d, m);
                self.put_single(d, result);
                self.float_result = (self.executed + 1, d);
                return Ok(wait);
            }
            Instruction::FloatToCore { t, n } => {
                self.put(t, self.single(n));
                return Ok(self.wait_for(n));
            }
            Instruction::CoreToFloat { t, n } => self.put_single(n, self.get(t)),
            Instruction::FloatPairToCore { t, t2, m } => {
                self.put(t, self.single(m));
                self.put(t2, self.single(m + 1));
            }
            Instruction::CoreToFloatPair { t, t2, m } => {
                self.put_single(m, self.get(t));
                self.put_single(m + 1, self.get(t2));
            }
            Instruction::ReadFloatStatus { t: 15 } => self.flags = Flags::from_bits(self.fpscr),
            Instruction::ReadFloatStatus { t } => self.put(t, self.fpscr),
            Instruction::WriteFloatStatus { t } => self.fpscr = self.get(t) & fpscr::ALL,
            Instruction::FloatLoadMultiple {
                d,
                count,
                n,
                before,
                write_back,
            } => return self.float_load_multiple(memory, (d, count), n, before, write_back),
            Instruction::FloatStoreMultiple {
                d,
                count,
                n,
                before,
                write_back,
            } => return self.float_store_multiple(memory, (d, count), n, before, write_back),
            // All others are executed elsewhere.
            _ => return Err(Fault::Unimplemented.into()),
        }
        Ok(0)
    }

    fn convert(&mut self, op: Convert, d: Reg, m: Reg) -> u32 {
        let (x, old) = (self.single(m), self.single(d));
        let status = &mut self.fpscr;
        match op {
            Convert::ToInteger { signed, to_zero } => float::to_integer(status, x, signed, to_zero),
            Convert::FromInteger { signed } => float::from_integer(status, x, signed),
            Convert::ToFixed {
                signed,
                half,
                places,
            } => float::to_fixed(status, x, signed, half, places),
            Convert::FromFixed {
                signed,
                half,
                places,
            } => float::from_fixed(status, x, signed, half, places),
            Convert::ToHalf { top } => {
                let half = float::to_half(status, x);
                if top {
                    old & 0xFFFF | half << 16
                } else {
                    old & 0xFFFF_0000 | half
                }
            }
            Convert::FromHalf { top } => {
                let half = if top { x >> 16 } else { x & 0xFFFF };
                float::from_half(status, half)
            }
        }
    }
}
