"""The commands, the console, the summary, exit statuses."""
