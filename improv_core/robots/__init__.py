"""What `improv.toml` says of robots and their world."""
