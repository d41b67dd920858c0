"""Parts that fail behind the estimator, and what becomes of the flight: docs/evidence/estimation.md."""
