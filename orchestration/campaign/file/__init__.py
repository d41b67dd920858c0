"""What a campaign's file says, as it stands."""
