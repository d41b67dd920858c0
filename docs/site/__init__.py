"""The documentation site: what `make site` gathers, builds and checks."""
