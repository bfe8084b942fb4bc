"""Library documents, library folders and append-only files on disk."""
