// JSON-RPC with a language server over its standard input and output.

const { spawn } = require("child_process");

class Connection {
  // `notified(method, params)` gets what the server tells; `ended(reason)` is called once.
  constructor([command, ...args], notified, ended) {
    this.notified = notified;
    this.last = 0;
    this.waiting = new Map();
    this.received = Buffer.alloc(0);
    this.process = spawn(command, args, { stdio: ["pipe", "pipe", "ignore"] });
    this.process.on("error", (error) => this._end(error.message, ended));
    this.process.on("exit", (code) => this._end(`it ended with ${code}`, ended));
    this.process.stdin.on("error", () => {}); // the exit says it
    this.process.stdout.on("data", (data) => this._take(data));
  }

  request(method, params, cancelled) {
    const id = ++this.last;
    cancelled?.onCancellationRequested(() => this.notify("$/cancelRequest", { id }));
    return new Promise((resolve, reject) => {
      if (this.over) {
        reject(new Error(this.over));
        return;
      }
      this.waiting.set(id, { resolve, reject });
      this._send({ id, method, params });
    });
  }

  notify(method, params) {
    if (!this.over) {
      this._send({ method, params });
    }
  }

  async close() {
    if (this.over) {
      return;
    }
    const late = setTimeout(() => this.process.kill(), 2000);
    await this.request("shutdown", null).catch(() => {});
    this.notify("exit", null);
    this.process.once("exit", () => clearTimeout(late));
    this.closed = true;
  }

  _send(message) {
    const body = Buffer.from(JSON.stringify({ jsonrpc: "2.0", ...message }));
    this.process.stdin.write(`Content-Length: ${body.length}\r\n\r\n`);
    this.process.stdin.write(body);
  }

  _take(data) {
    this.received = Buffer.concat([this.received, data]);
    for (;;) {
      const head = this.received.indexOf("\r\n\r\n");
      const found = head < 0 ? null : /content-length: *(\d+)/i.exec(this.received.toString("ascii", 0, head));
      const end = found === null ? Infinity : head + 4 + Number(found[1]);
      if (this.received.length < end) {
        return;
      }
      const message = JSON.parse(this.received.toString("utf8", head + 4, end));
      this.received = this.received.subarray(end);
      this._handle(message);
    }
  }

  _handle(message) {
    if (message.method === undefined) {
      const waiting = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (message.error) {
        waiting?.reject(new Error(message.error.message));
      } else {
        waiting?.resolve(message.result);
      }
    } else if (message.id === undefined) {
      this.notified(message.method, message.params);
    } else {
      this._send({ id: message.id, error: { code: -32601, message: "not supported" } });
    }
  }

  _end(reason, ended) {
    if (this.over) {
      return;
    }
    this.over = reason;
    for (const { reject } of this.waiting.values()) {
      reject(new Error(reason));
    }
    this.waiting.clear();
    if (!this.closed) {
      ended(reason);
    }
  }
}

module.exports = { Connection };
