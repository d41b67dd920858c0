"""Holds the commands, the console, the summary and exit statuses."""
