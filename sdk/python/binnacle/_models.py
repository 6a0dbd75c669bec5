# SPDX-License-Identifier: Apache-2.0
"""Models in Python: what a class of one is derived from, what it is handed, and how it is registered."""

import hashlib
import inspect
import os
import pickle
import traceback
import types
from collections import namedtuple

import numpy as np

from . import _core

Port = namedtuple("Port", "bound kind dof stored_size components")
Port.__doc__ = """What is plugged into a port: whether anything is, its kind ("vector:3:m"), its error dof, the size of its
value, and its error components, (name, unit) each."""

Driving = namedtuple("Driving", "t_ns rates bridges")
Driving.__doc__ = """The driving input: time of the state [ns], its mean rates by name over the last interval (None until one
has ended), and whether that bridged a hole in the input."""
Driving.t = property(lambda self: None if self.t_ns is None else self.t_ns * 1e-9, doc="[s]")  # type: ignore[attr-defined]

Innovation = namedtuple("Innovation", "t_ns dt keys groups residual HPHt R")
Innovation.__doc__ = """One innovation: time [ns]; dt since this measurement's last accepted sample [s], 0 at the first; who
each row is (m,), its group's index (m,), residual before the update (m,), H P⁻ Hᵀ (m, m), and nominal R (m, m)."""
Innovation.t = property(lambda self: self.t_ns * 1e-9, doc="[s]")  # type: ignore[attr-defined]

AfterUpdate = namedtuple("AfterUpdate", "outcome residual HPHt")
AfterUpdate.__doc__ = """What an update left: outcome ("accepted", "gated" …), residual r - H δ (m,), H P⁺ Hᵀ (m, m)."""

Refusal = namedtuple("Refusal", "kind reason")


def unsupported(reason):
    """What linearize or evaluate gives where the model does not apply: the sample counts as unsupported."""
    return Refusal("unsupported", reason)


def invalid(reason):
    """What linearize gives for a sample that is not usable; the run keeps a note of it."""
    return Refusal("invalid", reason)


def failed(reason):
    """What propagate gives where the model cannot continue: the filter stops with this as its diagnosis."""
    return Refusal("failed", reason)


class ComponentError(ValueError):
    """Raised in __init__ to refuse what the config says. pointer: of the member that is wrong ("/segments/3/radius")."""

    def __init__(self, message, pointer=""):
        super().__init__(message)
        self.pointer = pointer


class Sample:
    """One sample: sample["range"] is a float, or (rows,) of a field per row; NaN of an optional field that is not there.

    .t [s], .t_ns [ns, exact]; .t0, .t0_ns start of its interval, None of an instant; .rows; .covariance (n, n), None where
    the channel attaches none. A sample of a process model's input has .dt [s] and .bridges besides. Arrays are read-only.
    """

    __slots__ = ("_fields", "t_ns", "t0_ns", "rows", "covariance", "dt", "bridges")

    def __init__(self, fields, t_ns, t0_ns=None, rows=0, covariance=None, dt=None, bridges=False):
        self._fields, self.t_ns, self.t0_ns = fields, t_ns, t0_ns
        self.rows, self.covariance, self.dt, self.bridges = rows, covariance, dt, bridges

    def __getitem__(self, name):
        try:
            return self._fields[name]
        except KeyError:
            raise KeyError(f"the spec has no field {name!r}; it has {', '.join(map(repr, self._fields))}") from None

    @property
    def t(self):
        return self.t_ns * 1e-9

    @property
    def t0(self):
        return None if self.t0_ns is None else self.t0_ns * 1e-9

    def fields(self, *names):
        """Several fields as an array: sample.fields("vn", "ve", "vd") is (3,)."""
        return np.array([self[name] for name in names])


Step = namedtuple("Step", "t0_ns t1_ns dt samples bridges")
Step.__doc__ = """One propagation: from, to [ns]; dt [s]; the samples of the driving input that fill it, in order (none where
the spec has no fields); whether it bridges a hole in the input."""
Step.t0 = property(lambda self: self.t0_ns * 1e-9, doc="[s]")  # type: ignore[attr-defined]
Step.t1 = property(lambda self: self.t1_ns * 1e-9, doc="[s]")  # type: ignore[attr-defined]


class Spec:
    """What a class says of itself, once: parameters, ports, fields, and an example of its config, "type" left out.

    surroundings: what the example refers to and conform() can not guess: {"blocks": {…}, "sample": {field: number}, …}.
    """

    def __init__(self, summary, source="", parameters=(), ports=(), fields=(), driving_rates=(), inputs=(), kind="",
                 example=None, surroundings=None):
        self.summary, self.source, self.kind = summary, source, kind
        self.parameters, self.ports, self.fields = list(parameters), list(ports), list(fields)
        self.driving_rates, self.inputs = list(driving_rates), list(inputs)
        self.example, self.surroundings = example, surroundings


class _Model:
    """Immutable once it is bound: a run can then be repeated, resumed and rolled back."""

    spec = None

    def __init__(self, binding):
        pass

    def __setattr__(self, name, value):
        if "_is_bound" in self.__dict__:
            # In few words: a filter keeps the beginning of a diagnosis.
            raise AttributeError(
                f"{type(self).__name__}.{name} is set after the model is bound; declare what it remembers: "
                f'binding.keeps({{"{name}": 0.0}}), argument memory'
            )
        object.__setattr__(self, name, value)

    def __delattr__(self, name):
        self.__setattr__(name, None)
        object.__delattr__(self, name)


class MeasurementModel(_Model):
    """What is seen of the state.

    linearize(self, sample, x) gives (residual, H, R): residual z ⊟ h(x̂) (m,), or a number where m is 1; H = ∂h/∂δ by port,
    {"position": (m, dof)}, or None to have it made by central differences on the manifolds of the ports; R (m, m), or the
    variances of the rows (m,). A fourth may say who each row is (m integers). Or a refusal: unsupported("why"),
    invalid("why"). x is {"port": value}, None where a port is open. It may take by name: memory, u (Driving), auxiliary
    ({"input": Sample or None}), P ({("port", "port"): (n, n)}, where binding.wants_covariance()), notes (a list to which
    texts for people are appended), wants_H. All arrays that it is handed are read-only copies.
    """

    _role, _methods = "measurement model", {
        "linearize": (2, ("memory", "u", "auxiliary", "P", "notes", "wants_H")),
    }


class ProcessModel(_Model):
    """How blocks move between two instants.

    propagate(self, x, step) gives (x⁺, Phi, Qd): x⁺ {"port": value} of the ports that it advances; Phi = ∂δ(t1)/∂δ(t0),
    {("to", "from"): (n, n)}, or None to have it made by differences; a block that is not given is the identity (to = from) or
    zero. Qd {("port", "port"): (n, n)} of the noise that it adds, one of (a, b) and (b, a). It may take by name: memory,
    auxiliary, notes, wants_Phi.
    """

    _role, _methods = "process model", {"propagate": (2, ("memory", "auxiliary", "notes", "wants_Phi"))}


class NoiseEstimator(_Model):
    """How far a measurement is trusted.

    estimate(self, innovation) gives R (m, m), or variances (m,); after(self, update), where there is one, is called when the
    update is done. Both may take by name: memory, and estimate notes.
    """

    _role, _methods = "noise estimator", {"estimate": (1, ("memory", "notes")), "after": (1, ("memory",))}


class DerivedBlock(_Model):
    """A function of blocks that models bind to as if it were a block; binding.yields(…) says what it yields.

    evaluate(self, x) gives (value, J): J {"port": (dof, n)} or None to have it made by differences. It may take by name: u,
    notes, wants_J.
    """

    _role, _methods = "derived block", {"evaluate": (1, ("u", "notes", "wants_J"))}


class Transform(_Model):
    """Makes samples of samples. binding.emits("", [field("speed", "m/s")]) declares a channel of the component's own name.

    on(self, sample, emit) calls emit({"speed": 3.0}) for each sample that it makes: at most one on each channel. emit takes
    t=, t0= (seconds or numpy.timedelta64; by default those of the sample), channel= and covariance=. It may take by name:
    input (the name of the one that the sample came on), memory.
    """

    _role, _methods = "transform", {"on": (2, ("input", "memory"))}


class Emission:
    """emit of Transform.on()."""

    __slots__ = ("samples",)

    def __init__(self):
        self.samples = []

    def __call__(self, fields, t=None, t0=None, channel="", covariance=None):
        self.samples.append((channel, dict(fields), t, t0, covariance))


class CFunction:
    """See cfunc()."""

    def __init__(self, function, version=""):
        self.function, self.address, self.version = function, _address_of(function), version

    def __call__(self, *_):
        raise TypeError("this is a C function: the kernel calls it")


def cfunc(function, version=""):
    """A C function in place of a measurement model's method: `linearize = bn.cfunc(f)`. It runs without Python's lock.

    function: of numba.cfunc, of ctypes, or an address. version: part of what a snapshot is of; where the function comes from
    a library, the library's content is, and of numba the source's code.

        int32_t linearize(double t,                   // of the sample [s]
                          const double *constants,    // binding.constants([…])
                          const double *fields,       // of the sample, in the order of the spec
                          const double *row_fields,   // rows × fields per row, row by row
                          int32_t rows,
                          const double *x,            // stored values of the bound ports, one after the other
                          double *memory,             // binding.keeps({…}), 8 bytes each, in its order
                          double *residual,           // (max_rows)
                          double *H,                  // max_rows × dof, column-major, of each port that is read, one after
                                                      // the other; zero on entry
                          double *R);                 // max_rows × max_rows, column-major, zero on entry
    It gives the number of rows that it wrote, or -1 (unsupported), -2 (invalid), -3 (failed).
    """
    return CFunction(function, version)


def _address_of(function):
    if isinstance(function, int):
        return function
    if isinstance(getattr(function, "address", None), int):
        return function.address
    import ctypes

    if isinstance(function, ctypes._CFuncPtr):
        return ctypes.cast(function, ctypes.c_void_p).value
    raise TypeError(f"{function!r} is no function of numba.cfunc or ctypes, and no address")


# ---- registration


def register(cls=None, name=None):
    """Makes a class a component type: "type": "my_range", or "python/my_range", in a config that is loaded afterwards.

    As a decorator, @register or @register(name="my_range"), or as a call. Without name it is the class's in snake_case. A
    name that is registered already is replaced; what is loaded keeps what it was loaded with.
    """
    if cls is None:
        return lambda decorated: register(decorated, name)
    role = getattr(cls, "_role", None)
    if not inspect.isclass(cls) or role is None:
        raise TypeError(f"{cls!r} is not derived from MeasurementModel, ProcessModel, NoiseEstimator, DerivedBlock or Transform")
    if not isinstance(cls.spec, Spec):
        raise TypeError(f"{cls.__name__}.spec is {cls.spec!r}; it is a binnacle.Spec(…)")
    name = name or _snake_case(cls.__name__)
    extras = {method: _extras(cls, method, fixed, known) for method, (fixed, known) in cls._methods.items() if hasattr(cls, method)}
    missing = [method for method in cls._methods if method not in extras and method != "after"]
    if missing:
        raise TypeError(f"{cls.__name__} has no method {missing[0]}, which a {role} needs")
    _core.register_model(name, _core.roles[role], cls.spec, _code_of(cls), cls, extras)
    cls._registered_name = name
    return cls


def _snake_case(name):
    return "".join("_" + c.lower() if c.isupper() and i else c.lower() for i, c in enumerate(name))


def _extras(cls, method, fixed, known):
    """The arguments that a method takes by name, beyond `self` and those of its role."""
    function = getattr(cls, method)
    if isinstance(function, CFunction):
        return []
    names = [p.name for p in inspect.signature(function).parameters.values() if p.default is p.empty and p.kind is not p.VAR_KEYWORD]
    extras = names[1 + fixed :]
    if len(names) < 1 + fixed:
        raise TypeError(f"{cls.__name__}.{method} takes {', '.join(names)}; it is handed {fixed} arguments besides self")
    unknown = [extra for extra in extras if extra not in known]
    if unknown:
        raise TypeError(f"{cls.__name__}.{method} takes {unknown[0]!r}; besides its {fixed} there are {', '.join(known)}")
    return extras


def bound(model):
    """From now on nothing about the model changes: arrays that it keeps become read-only as well."""
    for value in list(model.__dict__.values()):
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    object.__setattr__(model, "_is_bound", True)


def state_of(model):
    """What the attributes of a model are, as bytes by name."""

    def bytes_of(value):
        try:
            return pickle.dumps(value)
        except Exception:
            return repr(value).encode()

    return {name: bytes_of(value) for name, value in vars(model).items()}


def changed(before, after):
    """Names of the attributes that are not what they were."""
    return sorted(name for name in before.keys() | after.keys() if before.get(name) != after.get(name))


# ---- what a class's code is


def _code_of(cls):
    """A hash of what the class does: bytecode and constants of its methods, and of what they call in its own module."""
    digest, seen = hashlib.sha256(), set()
    for base in reversed(cls.__mro__):
        if base.__module__.split(".")[0] in ("builtins", "binnacle"):
            continue
        for name, value in sorted(vars(base).items(), key=lambda item: item[0]):
            if name not in ("__dict__", "__weakref__", "__doc__", "_registered_name", "spec"):
                digest.update(name.encode())
                _add(digest, value, base.__module__, seen)
    return digest.hexdigest()


def _add(digest, value, module, seen):
    function = inspect.unwrap(value.__func__ if isinstance(value, (staticmethod, classmethod)) else value) if callable(value) or isinstance(
        value, (staticmethod, classmethod)) else value
    if isinstance(value, CFunction):
        _add_c_function(digest, value, module, seen)
    elif isinstance(value, property):
        for part in (value.fget, value.fset, value.fdel):
            _add(digest, part, module, seen)
    elif isinstance(function, types.FunctionType):
        if id(function) in seen:
            return
        seen.add(id(function))
        _add_code(digest, function.__code__, function.__globals__, module, seen)
        for cell in (*(function.__defaults__ or ()), *(c.cell_contents for c in function.__closure__ or () if _is_filled(c))):
            _add(digest, cell, module, seen)
    elif inspect.isclass(value):
        if value.__module__ == module and id(value) not in seen:
            seen.add(id(value))
            for name, part in sorted(vars(value).items(), key=lambda item: item[0]):
                if not name.startswith("__") or isinstance(part, types.FunctionType):
                    _add(digest, part, module, seen)
    elif isinstance(value, np.ndarray):
        digest.update(str((value.dtype, value.shape)).encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, (int, float, complex, str, bytes, bool, type(None), tuple, list, dict, frozenset)):
        digest.update(_text_of(value))


def _text_of(constant):
    """The order of a frozenset changes from one start of Python to the next."""
    return repr(sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant).encode()


def _is_filled(cell):
    try:
        cell.cell_contents
    except ValueError:
        return False
    return True


def _add_code(digest, code, names, module, seen):
    digest.update(code.co_code)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _add_code(digest, constant, names, module, seen)
        else:
            digest.update(_text_of(constant))
    for name in code.co_names:
        digest.update(name.encode())
        if name in names and getattr(names[name], "__module__", module) == module:
            _add(digest, names[name], module, seen)


def _add_c_function(digest, function, module, seen):
    digest.update(str(function.version).encode())
    python = getattr(function.function, "_pyfunc", None)
    if python is not None:
        _add(digest, python, module, seen)
    library = _core.library_at(function.address)
    if library:
        with open(library, "rb") as file:
            digest.update(file.read())


def traceback_of(error, trace):
    """What goes into a message, in one line: the error, and where it was raised, the innermost call first, for a filter keeps the
    beginning of a long diagnosis. The exception itself is kept for last_exception()."""
    global _last
    _last = error.with_traceback(trace)
    frames = [
        f"{os.path.basename(frame.filename)}:{frame.lineno} in {frame.name}: {frame.line}"
        for frame in reversed(traceback.extract_tb(trace))
    ]
    head = "".join(traceback.format_exception_only(type(error), error)).strip().replace("\n", " ")
    return "; from ".join([head, *frames])


_last = None


def last_exception():
    """What a model raised last, in any thread, with its __traceback__; None: nothing yet. `raise binnacle.last_exception()` or
    traceback.print_exception() show all of it, pdb.post_mortem() goes there."""
    return _last
