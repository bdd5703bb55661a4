"""Boards that are emulated: AVR by simavr, Cortex-M4 by QEMU; their serial lines as ports."""
