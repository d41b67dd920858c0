"""What goes wrong with a cluster; here, since Dask itself may not be installed."""

from __future__ import annotations


class CrewLost(RuntimeError):
    """The cluster is gone. What has been written stands."""
