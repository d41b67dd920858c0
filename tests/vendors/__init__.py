"""FMUs as other teams deliver them: ours with each usual convention and cause, and what is to be said of each."""
