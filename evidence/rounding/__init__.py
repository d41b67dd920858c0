"""Rounding errors of controller and allocator: bounds over a range, beside measured ones: docs/evidence/rounding.md."""
