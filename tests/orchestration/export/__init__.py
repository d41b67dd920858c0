"""Tests of what the exports of a scenario are made of."""
