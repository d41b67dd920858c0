"""The runs: a job, the processes that do it, their rows in a dataset."""
