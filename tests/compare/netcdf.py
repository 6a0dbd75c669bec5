# SPDX-License-Identifier: Apache-2.0
"""Numbers of a NetCDF file, by the library that Binnacle is built with. Text variables and attributes other than units are left out."""
import contextlib
import ctypes
import ctypes.util
import threading

SIZES = {1: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}
FORMATS = {1: "b", 3: "h", 4: "i", 5: "f", 6: "d", 7: "B", 8: "H", 9: "I", 10: "q", 11: "Q"}
TEXT = 2
NAME = 257

_lock = threading.Lock()  # the library knows nothing of threads


def library():
    name = ctypes.util.find_library("netcdf")
    return ctypes.CDLL(name) if name else None


class Variable:
    def __init__(self, kind, shape, data, units):
        self.kind, self.shape, self.data, self.units = kind, shape, data, units

    def values(self):
        return memoryview(self.data).cast(FORMATS[self.kind])


class _Reader:
    def __init__(self, lib, path):
        self.lib, self.path = lib, path

    def call(self, name, *arguments):
        status = getattr(self.lib, name)(*arguments)
        if status != 0:
            raise OSError(f"{self.path}: {name}: NetCDF error {status}")

    def ids(self, name, group):
        count = ctypes.c_int()
        self.call(name, group, ctypes.byref(count), None)
        ids = (ctypes.c_int * max(1, count.value))()
        self.call(name, group, ctypes.byref(count), ids)
        return list(ids)[:count.value]

    def text(self, group, variable, attribute):
        kind, length = ctypes.c_int(), ctypes.c_size_t()
        if self.lib.nc_inq_att(group, variable, attribute, ctypes.byref(kind), ctypes.byref(length)) != 0:
            return ""
        if kind.value != TEXT:
            return ""
        text = ctypes.create_string_buffer(length.value + 1)
        self.call("nc_get_att_text", group, variable, attribute, text)
        return text.raw[:length.value].decode("utf-8", "replace").rstrip("\0")

    def variable(self, group, variable):
        name = ctypes.create_string_buffer(NAME)
        kind, dimensions, attributes = ctypes.c_int(), ctypes.c_int(), ctypes.c_int()
        places = (ctypes.c_int * 1024)()
        self.call("nc_inq_var", group, variable, name, ctypes.byref(kind), ctypes.byref(dimensions), places,
                  ctypes.byref(attributes))
        if kind.value not in SIZES:
            return name.value.decode(), None
        shape, count = [], 1
        for at in range(dimensions.value):
            length = ctypes.c_size_t()
            self.call("nc_inq_dimlen", group, places[at], ctypes.byref(length))
            shape.append(length.value)
            count *= length.value
        data = bytearray(count * SIZES[kind.value])
        if count:
            self.call("nc_get_var", group, variable, (ctypes.c_char * len(data)).from_buffer(data))
        return name.value.decode(), Variable(kind.value, tuple(shape), data, self.text(group, variable, b"units"))

    def group(self, group, path, found):
        for variable in self.ids("nc_inq_varids", group):
            name, content = self.variable(group, variable)
            if content is not None:
                found[path + (name,)] = content
        for inner in self.ids("nc_inq_grps", group):
            name = ctypes.create_string_buffer(NAME)
            self.call("nc_inq_grpname", inner, name)
            self.group(inner, path + (name.value.decode(),), found)


def read(lib, path):
    """{(group, …, variable): Variable} of every variable of numbers."""
    with _lock:
        with contextlib.suppress(AttributeError):
            lib.H5Eset_auto2(ctypes.c_int64(0), None, None)  # HDF5 prints what NetCDF only asks for, thread by thread
        reader, file, found = _Reader(lib, path), ctypes.c_int(), {}
        reader.call("nc_open", str(path).encode(), 0, ctypes.byref(file))
        try:
            reader.group(file.value, (), found)
        finally:
            lib.nc_close(file)
        return found
