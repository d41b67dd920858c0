"""The least time of the tumbles of docs/evidence/flight.md, by numerical optimal control, beside the time flown."""
