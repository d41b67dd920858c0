"""What docs/evidence/estimation.md says of the estimator: consistency, steady state, convergence, a public filter
beside it."""
