"""The protocol, with an answer to every request, also to one that cannot be understood."""

from collections.abc import Iterator
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import (
    JsonRpcException,
    JsonRpcInvalidParams,
    JsonRpcInvalidRequest,
    JsonRpcParseError,
    JsonRpcServerNotInitialized,
)
from pygls.protocol.language_server import LanguageServerProtocol, lsp_method

__all__ = ["Protocol"]


class Protocol(LanguageServerProtocol):
    """The library's protocol, where it falls short.

    It keeps changed texts itself, breaks lines where the protocol does not (U+2028, form feed), and
    clips the ranges of a change in place, so that no handler sees what was sent: texts are kept by
    `Project` alone. And it drops requests that it cannot read, so that editors wait, and answers
    those that come before `initialize`.
    """

    @lsp_method(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(
        self, params: lsp.DidChangeTextDocumentParams
    ) -> Iterator[object]:
        """Hands the change on."""
        yield self.fm.features[lsp.TEXT_DOCUMENT_DID_CHANGE], (params,), None

    def structure_message(self, data: dict[str, Any]) -> Any:
        """The data as it is: it is called for objects within messages, too."""
        return data

    def handle_message(self, message: Any) -> None:
        """Gives a message to its handler, or says why it is refused."""
        try:
            self._refuse_misplaced(message)
            structured = self._structured(message)
        except JsonRpcException as refusal:
            self._answer_with(refusal, message)
        else:
            super().handle_message(structured)

    def refuse_unreadable(self) -> None:
        """Answers what is no JSON: nobody knows which request it was."""
        self._send_error(None, JsonRpcParseError())

    def _structured(self, message: dict[str, Any]) -> Any:
        try:
            return super().structure_message(message)
        except JsonRpcException as error:
            raise JsonRpcInvalidParams from error

    def _refuse_misplaced(self, message: Any) -> None:
        """Raises what a message is answered with if it is none, or none for now."""
        if not isinstance(message, dict) or message.get("jsonrpc") != self.VERSION:
            raise JsonRpcInvalidRequest
        if "method" not in message:
            return  # the editor's answer to a request of ours
        method = message["method"]
        is_request = "id" in message
        if not isinstance(method, str) or (is_request and not _is_number(message["id"])):
            raise JsonRpcInvalidRequest
        if method == lsp.EXIT:
            return
        is_open = self._workspace is not None
        if self._shutdown or (is_open and method == lsp.INITIALIZE):
            raise JsonRpcInvalidRequest
        if not is_open and method != lsp.INITIALIZE:
            raise JsonRpcServerNotInitialized
        if is_request:
            self._get_handler(method)  # JsonRpcMethodNotFound if there is none

    def _answer_with(self, refusal: JsonRpcException, message: Any) -> None:
        """Answers a request with an error; a notification and an answer get none."""
        data = message if isinstance(message, dict) else {"id": None, "method": None}
        if "id" in data and "method" in data:
            number = data["id"] if _is_number(data["id"]) else None
            self._send_error(number, refusal)

    def _send_error(self, number: int | str | None, error: JsonRpcException) -> None:
        # The library leaves a number out that is null; the protocol wants it.
        answer = {"jsonrpc": self.VERSION, "id": number, "error": error.to_response_error()}
        self._send_data(answer)


def _is_number(number: object) -> bool:
    """Whether a request may have this number: the protocol allows texts, too."""
    return isinstance(number, int | str)
