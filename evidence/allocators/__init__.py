"""The paper's allocator and the bounded one under the paper's law: docs/evidence/allocators.md."""
