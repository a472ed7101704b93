"""The protocol, with an answer to every request, also to one that cannot be understood."""

from collections.abc import Iterator
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException, JsonRpcInvalidRequest
from pygls.protocol.json_rpc import JsonRPCNotification
from pygls.protocol.language_server import LanguageServerProtocol, lsp_method

__all__ = ["Protocol"]

ANSWERED = "$/facetlog/answered"
"""What stands in the place of a request that was refused already; `$/` may be passed over."""

_PARTS = ("id", "method")


class Protocol(LanguageServerProtocol):
    """The library's protocol, where it falls short.

    It keeps changed texts itself, breaks lines where the protocol does not (U+2028, form feed), and
    clips the ranges of a change in place, so that no handler sees what was sent: texts are kept by
    `Project` alone. And it drops requests whose parameters it cannot read, so that editors wait.
    """

    @lsp_method(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(
        self, params: lsp.DidChangeTextDocumentParams
    ) -> Iterator[object]:
        """Hands the change on."""
        yield self.fm.features[lsp.TEXT_DOCUMENT_DID_CHANGE], (params,), None

    def structure_message(self, data: dict[str, Any]) -> Any:
        """A message as the library has it; what it cannot read is answered here."""
        try:
            return super().structure_message(data)
        except JsonRpcException as refusal:
            return self._refused(data, refusal)

    def handle_message(self, message: Any) -> None:
        """Gives a message to whom it concerns; refuses what is none, and what comes too late."""
        if not hasattr(message, "jsonrpc"):
            data = message if isinstance(message, dict) else {}
            message = self._refused(data, JsonRpcInvalidRequest())
        elif message.jsonrpc != self.VERSION or self._is_late(message):
            data = {name: getattr(message, name) for name in _PARTS if hasattr(message, name)}
            message = self._refused(data, JsonRpcInvalidRequest())
        if getattr(message, "method", "") != ANSWERED:
            super().handle_message(message)

    def _is_late(self, message: Any) -> bool:
        return self._shutdown and getattr(message, "method", lsp.EXIT) != lsp.EXIT

    def _refused(self, data: dict[str, Any], refusal: JsonRpcException) -> JsonRPCNotification:
        """Answers a request with an error; a notification and an answer get none."""
        number = data.get("id")
        if "method" in data and isinstance(number, int | str):
            self._send_response(number, error=refusal.to_response_error())
        return JsonRPCNotification(method=ANSWERED, jsonrpc=self.VERSION, params=None)
