"""The page that shows robots move, and its server."""
