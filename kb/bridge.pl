:- module(facetlog_bridge, [ request/3         % +Operation, +Text, -Reply
                           ]).

/** <module> The one door between Python and Prolog

Python hands over an operation and a text, and gets a text back; nothing else crosses. A request is
deterministic and never raises, so no query is ever open between two requests. The reply is
["ok", Term] or ["error", Kind, Message] in JSON, where a term is

  - a number: an integer of any size or a float;
  - {"a": Text}: an atom; {"s": Text}: a string; {"v": Name}: a variable; {"x": Text}: other atomics;
  - [...]: a proper list;
  - {"f": Name, "t": [...]}: a compound.

All text is ASCII, with escapes: neither NUL nor a character outside Latin-1 can be lost on the way.
*/

:- prolog_load_context(directory, Directory),
   asserta(user:file_search_path(facetlog_kb, Directory)),
   asserta((user:file_search_path(facetlog, Rules) :-
                file_directory_name(Directory, House),
                atom_concat(House, '/rules', Rules))).

:- use_module(library(error)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(solution_sequences)).
:- use_module(library(time)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog(vocabulary)).

%!  request(+Operation, +Text, -Reply) is det.

request(Operation, Text, Reply) :-
    catch(answer(Operation, Text, Result), Error, true),
    (   nonvar(Error)
    ->  problem(Error, Kind, Message),
        json([{s:"error"}, {s:Kind}, {s:Message}], Reply)
    ;   json([{s:"ok"}, Result], Reply)
    ).

answer(Operation, Text, Result) :-
    (   operation(Operation, Text, Result0)
    ->  Result = Result0
    ;   Result = failed
    ).

operation("new_scene", _, Scene) :-
    new_scene(Scene).
operation("add_facts", Text, true) :-
    % The first term of the text names the scene.
    setup_call_cleanup(
        open_string(Text, Stream),
        ( read_term(Stream, Scene, []),
          add_facts(Scene, Stream) ),
        close(Stream)).
operation("drop_scene", Text, true) :-
    term_string(Scene, Text),
    drop_scene(Scene).
operation("load_builtin", Text, Loaded) :-
    term_string(Path, Text),
    load_builtin(Path, Loaded).
operation("load_rules", Text, Loaded) :-
    term_string(Path, Text),
    load_user_rules(Path, Loaded).
operation("drop_rules", Text, true) :-
    term_string(Module, Text),
    drop_rules(Module).
operation("judge", Text, Verdict) :-
    term_string(judge(Scene, Module, Model, Thing, Limits), Text),
    within_limits(Limits, in_scene(Scene, judge(Module, Model, Thing, Verdict))).
operation("query", Text, Solutions) :-
    term_string(query(Scene, Goal, Limits, Most), Text, [variable_names(Bindings)]),
    check_query(Goal),
    within_limits(Limits,
                  findall(Bindings,
                          limit(Most, in_scene(Scene, facetlog_query:Goal)),
                          Solutions)).
operation("version", _, Version) :-
    current_prolog_flag(version, Version).

%   Both limits must stand inside the goal: around a door of C they would not be heeded.
within_limits(limits(Seconds, Inferences), Goal) :-
    call_with_time_limit(Seconds, call_with_inference_limit(Goal, Inferences, Result)),
    (   Result == inference_limit_exceeded
    ->  resource_error(inferences)
    ;   true
    ).

                 /*******************************
                 *           MESSAGES           *
                 *******************************/

problem(rule_error(File, Line, Format, Args), "rules", Message) :-
    !,
    format(string(What), Format, Args),
    (   Line > 0
    ->  format(string(Message), "~w:~d: ~w", [File, Line, What])
    ;   format(string(Message), "~w: ~w", [File, What])
    ).
problem(error(type_error(comparable, Test), _), "rules", Message) :-
    !,
    format(string(Message),
           "~p compares a length with a bare number: write metres(...) or a share of another length",
           [Test]).
problem(error(existence_error(Kind, What), _), "rules", Message) :-
    memberchk(Kind, [word, tolerance]),
    !,
    format(string(Message), "~p is no ~w of the model or the vocabulary", [What, Kind]).
problem(time_limit_exceeded, "limit", "the time limit was reached") :- !.
problem(error(resource_error(What), _), "limit", Message) :-
    !,
    format(string(Message), "the limit of ~w was reached", [What]).
problem(Error, "prolog", Message) :-
    message_to_codes_string(Error, Message0),
    split_string(Message0, "\n", " \t", Lines),
    exclude(==(""), Lines, Filled),
    atomics_to_string(Filled, Message).

message_to_codes_string(Error, String) :-
    message_to_lines(Error, Lines),
    with_output_to(string(String), print_message_lines(current_output, '', Lines)).

message_to_lines(Error, Lines) :-
    '$messages':translate_message(Error, Lines, [nl]).

atomics_to_string(Lines, String) :-
    atomic_list_concat(Lines, ' ', Atom),
    atom_string(Atom, String).

                 /*******************************
                 *             JSON             *
                 *******************************/

%   Variables are named in the order in which they occur, so that equal terms give equal text.
json(Term, Text) :-
    with_output_to(string(Text),
                   \+ \+ ( numbervars(Term, 0, _, [functor_name('facetlog variable')]),
                           json(Term) )).

json('facetlog variable'(N)) :- !, format(atom(Name), "X~d", [N]), tagged("v", Name).
json({s:Text}) :- !, quoted(Text).
json(X) :- integer(X), !, write(X).
json(X) :- float(X), finite(X), !, write(X).
json(X) :- X == [], !, write([]).
json(X) :- atom(X), !, tagged("a", X).
json(X) :- string(X), !, tagged("s", X).
json(X) :- atomic(X), !, tagged("x", X).
json(X) :- is_list(X), !, write('['), json_items(X), write(']').
json(X) :-
    compound_name_arguments(X, Name, Args),
    write('{"f":'), quoted(Name),
    write(',"t":['), json_items(Args), write(']}').

finite(X) :-
    X =:= X,
    abs(X) =\= inf.

json_items([]).
json_items([X|Xs]) :-
    json(X),
    forall(member(Y, Xs), ( write(','), json(Y) )).

tagged(Tag, X) :-
    format(string(Text), "~w", [X]),
    format("{\"~w\":", [Tag]),
    quoted(Text),
    write('}').

quoted(Text) :-
    string_codes(Text, Codes),
    put_char('"'),
    maplist(put_escaped, Codes),
    put_char('"').

put_escaped(0'") :- !, write('\\"').
put_escaped(0'\\) :- !, write('\\\\').
put_escaped(Code) :- Code >= 32, Code < 127, !, put_code(Code).
put_escaped(Code) :- Code =< 0xFFFF, !, format("\\u~|~`0t~16r~4+", [Code]).
put_escaped(Code) :-
    High is 0xD800 + ((Code - 0x10000) >> 10),
    Low is 0xDC00 + ((Code - 0x10000) /\ 0x3FF),
    put_escaped(High),
    put_escaped(Low).
