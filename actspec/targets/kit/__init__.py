"""What every target does alike: losses by joint and their sizes, provenance, Python text, networks."""
