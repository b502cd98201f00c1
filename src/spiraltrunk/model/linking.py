"""Linking of kernels: each is optimised once, in the kernel that Python calls."""

from __future__ import annotations

from typing import Any, final

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags


@final
class _Part(JITCodeLibrary):
    """Code of a kernel that is called by others: it is optimised and made machine code where it is linked."""

    @property
    def codegen(self) -> _Part:
        """What `set_env` is called on."""
        return self

    def set_env(self, name: str, env: object) -> None:
        """There is no code in memory yet that could have an environment."""

    def finalize(self) -> None:
        """Leave it as it is."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None."""
        return 0


@final
class _Whole(JITCodeLibrary):
    """Code of a kernel that Python calls, with that of all kernels below it, optimised once."""

    def finalize(self) -> None:
        """Link the parts, which go where nothing calls them any more, then all that Numba does."""
        module, linked = self._final_module, list(dict.fromkeys(self._linking_libraries))
        own = {function.name for function in module.functions if not function.is_declaration}
        for library in linked:  # Grows on the way.
            if isinstance(library, _Part):
                module.link_in(library._final_module, preserve=True)
                linked += [further for further in dict.fromkeys(library._linking_libraries) if further not in linked]
        for function in module.functions:
            if function.name not in own and not function.is_declaration:
                function.linkage = "linkonce_odr"
        self._linking_libraries = [library for library in linked if not isinstance(library, _Part)]
        super().finalize()  # type: ignore[no-untyped-call]


@final
class _Flags(Flags):
    """Numba's options of one function, sooner told from others: that is asked for a hundred thousand times."""

    def __hash__(self) -> int:
        return len(self._values)

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, _Flags) and bool(self._values == other._values))


def _pipeline(kind: type[_Part | _Whole]) -> type[Compiler]:
    """Numba's compiler, with libraries of this kind."""

    class Pipeline(Compiler):
        def __init__(self, *scene: Any) -> None:
            super().__init__(*scene)  # type: ignore[no-untyped-call]
            self.state.flags = _Flags(self.state.flags)  # type: ignore[no-untyped-call]

        def define_pipelines(self) -> Any:
            self.state.library = kind(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
            self.state.library.enable_object_caching()
            return super().define_pipelines()  # type: ignore[no-untyped-call]

    return Pipeline


PART, LINKED_WHOLE = _pipeline(_Part), _pipeline(_Whole)
