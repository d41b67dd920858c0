"""The flight code in single precision, for processors without double precision: docs/evidence/single.md."""
