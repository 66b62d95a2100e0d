from typing import Any

ffi: Any  # cffi's: makes and reads the structs of the C library
lib: Any  # every public function and constant of the C library
