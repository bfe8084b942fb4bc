"""The model: frozen values, and the documents that hold them (paper section 3.1)."""
