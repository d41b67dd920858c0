"""The paper's claims examined: docs/reproduction.md."""
