:- module(facetlog_faults, [ fault/4               % +Error, -Kind, -Message, -Place
                           ]).

/** <module> Errors of a request as what a person reads
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(plain_errors)).

%!  fault(+Error, -Kind, -Message, -Place) is det.
%
%   What Error is, in plain words; Place is [Start, End] in the text of a question, or empty.

fault(facetlog_interrupt(Why), "limit", Message, []) :-
    !,
    interrupt_message(Why, Message).
fault(question_error(Start, End, Format, Args), "question", Message, [Start, End]) :-
    !,
    format(string(Message), Format, Args).
fault(rule_faults(Messages), "rules", Message, []) :-
    !,
    atomic_list_concat(Messages, '\n', Message).
fault(error(type_error(comparable, Test), _), "rules", Message, []) :-
    !,
    format(string(Message),
           "~p compares a length with a bare number: write metres(...) or a share of another length",
           [Test]).
fault(error(existence_error(Kind, What), _), "rules", Message, []) :-
    memberchk(Kind, [word, tolerance]),
    !,
    format(string(Message), "~p is no ~w of the model or the vocabulary", [What, Kind]).
fault(error(existence_error(model, Model), _), "rules", Message, []) :-
    !,
    format(string(Message), "a rule asks for the model ~w, which is not loaded", [Model]).
fault(error(existence_error(Kind, Name), Context), "question", Message, [0, 0]) :-
    nothing_of(Kind, Format),
    !,
    format(string(Nothing), Format, [Name]),
    what_is_there(Context, There),
    string_concat(Nothing, There, Message).
fault(error(python_error(Key, Message), _), "python", Message, [Key]) :- !.
fault(inference_limit_exceeded, "limit", "the limit of inferences was reached", []) :- !.
fault(error(resource_error(What), _), "limit", Message, []) :-
    !,
    resource(What, Name),
    format(string(Message), "the limit of ~w was reached", [Name]).
fault(models_not_ready(Models, Error), Kind, Message, Place) :-
    !,
    fault(Error, Kind, Why, Place),
    atomic_list_concat(Models, ', ', Names),
    format(string(Message), "the model ~w cannot be prepared: ~w", [Names, Why]).
fault(Error, "prolog", Message, []) :-
    plain_error(Error, Message),
    !.
fault(Error, "prolog", Message, []) :-
    '$messages':translate_message(Error, Lines, [nl]),
    with_output_to(string(Message0), print_message_lines(current_output, '', Lines)),
    normalize_space(string(Message), Message0).

nothing_of(thing, "the scene has no thing ~w").
nothing_of(part, "the scene has no face or edge ~w").
nothing_of(role, "the model has no part ~w").
nothing_of(name, "the scene has neither a name nor a fact ~w").

%   What there is instead, as near_miss.pl says it.
what_is_there(Context, There) :-
    nonvar(Context),
    Context = there(Names),
    Names \== [],
    !,
    atomic_list_concat(Names, ', ', Text),
    string_concat(": it has ", Text, There).
what_is_there(_, "").

interrupt_message(time_limit, "the time limit was reached").
interrupt_message(stopped, "the question was stopped").

resource(inferences, "inferences") :- !.
resource(What, "memory (Prolog's stacks)") :- memberchk(What, [stack, private_table_space]), !.
resource(text, "text (characters of names that are made)") :- !.
resource(term_size, "the size of a term") :- !.
resource(number_length, "the length of a number") :- !.
resource(What, What).
