"""What the user wrote, with its lines."""
