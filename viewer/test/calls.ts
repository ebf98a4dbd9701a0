/** Calls of the page as the tests and the mock write them: by the name of the method and with its messages as objects. */
import {
  create,
  fromBinary,
  toBinary,
  type DescMethod,
  type MessageInitShape,
  type MessageShape,
} from "@bufbuild/protobuf";
import { BrainLinkService } from "../src/gen/baudbot/v1/brain_link_pb";
import { ControlService } from "../src/gen/baudbot/v1/control_pb";
import { ObserveService } from "../src/gen/baudbot/v1/observe_pb";
import {
  ClosedSchema,
  FailureSchema,
  PageRequestSchema,
  PageResponseSchema,
  TakenSchema,
} from "../src/gen/baudbot/v1/page_pb";

const METHODS = { ...ControlService.method, ...ObserveService.method, ...BrainLinkService.method };
type Methods = typeof METHODS;

/** What a page asks: a method with its request, or the end of a call. */
export type Asked =
  { [K in keyof Methods]: { case: K; value: MessageShape<Methods[K]["input"]> } }[keyof Methods] | { case: "close" };

/** What a page is answered: a response of a method, or what becomes of the call. */
export type Reply =
  | { [K in keyof Methods]: { case: K; value: MessageInitShape<Methods[K]["output"]> } }[keyof Methods]
  | { case: "closed" }
  | { case: "taken" }
  | { case: "failure"; value: { code: string; message: string } };

/** One message of a page. Of the methods only Attach takes further requests. */
export function requestFrom(bytes: Uint8Array): { call: number; request: Asked } {
  const { call, request } = fromBinary(PageRequestSchema, bytes);
  if (request.case === "begin") {
    const [, name] = request.value.method.split("/");
    const method = Object.values<DescMethod>(METHODS).find((one) => one.name === name);
    if (!method) throw new Error(`no method ${request.value.method}`);
    const value = fromBinary(method.input, request.value.request);
    return { call, request: { case: method.localName, value } as unknown as Asked };
  }
  if (request.case !== "next") return { call, request: { case: "close" } };
  return { call, request: { case: "attach", value: fromBinary(METHODS.attach.input, request.value) } };
}

/** One message to a page. */
export function responseTo(call: number, reply: Reply): Uint8Array {
  return toBinary(PageResponseSchema, create(PageResponseSchema, { call, response: responseOf(reply) }));
}

function responseOf(reply: Reply): MessageInitShape<typeof PageResponseSchema>["response"] {
  switch (reply.case) {
    case "closed":
      return { case: "closed", value: create(ClosedSchema) };
    case "taken":
      return { case: "taken", value: create(TakenSchema) };
    case "failure":
      return { case: "failure", value: create(FailureSchema, reply.value) };
    default: {
      const { output }: DescMethod = METHODS[reply.case];
      return { case: "message", value: toBinary(output, create(output, reply.value as Record<string, unknown>)) };
    }
  }
}
