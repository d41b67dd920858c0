"""The flight code on an emulated Cortex-M7, in the loop through the link: docs/evidence/processor.md."""
