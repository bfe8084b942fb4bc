"""Looking back: why a run went as it did, and whether lessons that were learned still are."""
