"""Long tests: programs that are killed, servers with a thousand visits, pages open for an hour."""
