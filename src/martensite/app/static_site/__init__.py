"""The bench as static files: runs by WebAssembly in the browser, without a server.

Each structure becomes a module of the C of the server (`run_module`). Each scenario becomes a table of its inputs
(`flat_inputs`), with their dependence on the controls of its form (`input_map`), measured with the builder.
"""
