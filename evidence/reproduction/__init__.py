"""The paper's claims examined: docs/evidence/reproduction.md."""
