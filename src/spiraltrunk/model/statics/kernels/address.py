"""Named tuples by their address: one argument of a call, where Numba passes each number and array of a tuple apart."""

from __future__ import annotations

from typing import Any, final

from numba.core import cgutils, types
from numba.core.datamodel import models, register_default  # type: ignore[attr-defined]
from numba.core.imputils import impl_ret_borrowed, lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr, signature
from numba.extending import intrinsic


@final
class Address(types.Type):
    """Type of a named tuple's address; a field is read where it is used."""

    def __init__(self, content: types.BaseNamedTuple) -> None:
        self.content = content
        super().__init__(f"Address({content.name})")


@final
@register_default(Address)
class _Pointer(models.PrimitiveModel):
    def __init__(self, manager: Any, address: Address) -> None:
        super().__init__(manager, address, manager.lookup(address.content).get_value_type().as_pointer())

    def from_argument(self, builder: Any, value: Any) -> Any:
        """An argument marked as never written through, so that a field need not be read again after a write."""
        value.add_attribute("noalias")
        value.add_attribute("nonnull")
        return value


@final
@infer_getattr
class _Fields(AttributeTemplate):
    key = Address

    def generic_resolve(self, address: Any, name: str) -> Any:  # type: ignore[override]
        """Type of a field; None for an unknown one."""
        fields = address.content.fields
        return address.content.types[fields.index(name)] if name in fields else None


@lower_getattr_generic(Address)  # type: ignore[untyped-decorator]
def _read(context: Any, builder: Any, address: Any, value: Any, name: str) -> Any:
    index = address.content.fields.index(name)
    field = builder.load(cgutils.gep_inbounds(builder, value, 0, index))
    return impl_ret_borrowed(context, builder, address.content.types[index], field)


def _take_address(typing: Any, content: Any) -> Any:
    """Store a named tuple and those in it on the stack and return its address; an address is returned as it is.

    The address is valid while the calling function runs, which must not return it. Its arrays must be those of
    arguments, since nothing counts a reference to them.
    """
    if isinstance(content, Address):
        return signature(content, content), lambda context, builder, call, values: values[0]
    return signature(address_of(content), content), lambda context, builder, call, values: _store(
        builder, context, content, values[0]
    )


by_address: Any = intrinsic(_take_address)
"""`_take_address` as kernels call it, with the tuple alone."""


def address_of(content: Any) -> Address:
    """Type of the address of a named tuple type."""
    parts = [address_of(part) if isinstance(part, types.BaseNamedTuple) else part for part in content.types]
    return Address(types.BaseTuple.from_types(parts, content.instance_class))


def _store(builder: Any, context: Any, content: Any, value: Any) -> Any:
    parts = []
    for index, part in enumerate(content.types):
        field = builder.extract_value(value, index)
        parts.append(_store(builder, context, part, field) if isinstance(part, types.BaseNamedTuple) else field)
    kept = cgutils.make_anonymous_struct(builder, parts, context.get_value_type(address_of(content).content))
    return cgutils.alloca_once_value(builder, kept)
