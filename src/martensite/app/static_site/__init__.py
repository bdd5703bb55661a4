"""The bench as static files: runs by WebAssembly in the browser, and no server.

Every structure becomes a module of the C that runs on the server (`run_module`); every scenario a
table of the numbers that go in (`flat_inputs`), and how they follow from the controls of its form
(`input_map`), measured on the builder itself.
"""
