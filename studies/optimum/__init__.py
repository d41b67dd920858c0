"""The least time of the tumbles of docs/flight.md, by numerical optimal control, beside the time flown."""
