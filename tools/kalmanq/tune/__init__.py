"""The page of `kalmanq tune`: the library in WebAssembly, a model and a recording in one HTML file."""
