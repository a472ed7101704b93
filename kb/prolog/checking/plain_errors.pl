:- module(facetlog_plain_errors, [ fault/4,            % +Error, -Kind, -Message, -Place
                                   placed/9            % +Kind0, +Message0, +Place0, +Error,
                                                       % +Operation, +Text, -Kind, -Message, -Place
                                 ]).

/** <module> Errors of Prolog in words that need no Prolog

What the library and the arithmetic of SWI-Prolog throw names its own types (order_specifier,
not_less_than_zero). A message names the word that was called, what it needs, and what it was given:

    atom_length/2 needs a whole number, not foo
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(reading)).
:- use_module(facetlog_kb(white_list)).

%   plain_error(+Error, -Message) is semidet.
%
%   Message says in one line what Error, error(Formal, Context), is about. Fails for errors that
%   Prolog's library does not throw.

plain_error(error(Formal, Context), Message) :-
    (   word_called(Context, Word)
    ->  true
    ;   Word = none
    ),
    plain_error(error(Formal, Context), Word, Message).

%   plain_error(+Error, +Word, -Message) is semidet.
%
%   The same where the Word that was called is known, Name/Arity, or none.

plain_error(error(Formal, _), Word, Message) :-
    nonvar(Formal),
    said(Formal, Format, Args0),
    maplist(shown, Args0, Args),
    format(string(What), Format, Args),
    (   Word = Name/Arity
    ->  format(string(Message), "~w/~d ~s", [Name, Arity, What])
    ;   format(string(Message), "a goal ~s", [What])
    ).

%   What follows the name of the word.
said(instantiation_error, "needs a value where there is none yet", []).
said(uninstantiation_error(Found), "needs a variable without a value, not ~s", [Found]).
said(type_error(evaluable, Found), Format, [Shown]) :-
    !,
    not_evaluable(Found, Format, Shown).
said(type_error([], Found), "needs a number, not ~s", [Found]) :- !.
said(type_error(Type, Found), "needs ~s, not ~s", [plain(Plain), Found]) :-
    type_in_words(Type, Plain).
said(domain_error(Domain, Found), "needs ~s, not ~s", [plain(Plain), Found]) :-
    domain_in_words(Domain, Plain).
said(evaluation_error(What), Format, []) :-
    evaluation_in_words(What, Format).
said(representation_error(What), "is given a character that it cannot take", []) :-
    memberchk(What, [character, character_code, code_point]),
    !.
said(representation_error(_), "is given a number or a text that is too large for it", []).
said(existence_error(matching_rule, _), "needs lists", []).
said(existence_error(matching_rule, _, _), "needs lists", []).
said(existence_error(type, Found), "needs a goal that says <, = or >, not ~s", [Found]).
said(existence_error(procedure, Found), "calls ~s, which there is not", [Found]).
said(syntax_error(_), "is given a text that is no number", []).
said(permission_error(_, _, Found), "may not change ~s", [Found]).

not_evaluable(Found, "computes with ~s, which is no number", Name) :-
    nonvar(Found),
    Found = Name/0,
    !.
not_evaluable(Found, "computes with ~s, which is no function of numbers", Found) :-
    nonvar(Found),
    Found = _/_,
    !.
not_evaluable(Found, "computes with ~s, which is no number", Found).

type_in_words(Type, Plain) :-
    (   Type = [_|_]
    ->  Plain = "a list"
    ;   plain_type(Type, Plain)
    ->  true
    ;   Type = list(Of),
        plain_type(Of, Each)
    ->  format(string(Plain), "a list, of which each is ~s", [Each])
    ;   Type = oneof(Known)
    ->  format(string(Plain), "one of ~q", [Known])
    ;   spaced(Type, Plain)
    ).

plain_type(list, "a list").
plain_type(proper_list, "a list").
plain_type(list_or_partial, "a list").
plain_type(atom, "a name").
plain_type(symbol, "a name").
plain_type(callable, "a goal").
plain_type(atomic, "a name, a number or a string").
plain_type(integer, "a whole number").
plain_type(nonneg, "a whole number from 0").
plain_type(positive_integer, "a whole number from 1").
plain_type(negative_integer, "a whole number below 0").
plain_type(number, "a number").
plain_type(float, "a floating point number").
plain_type(rational, "a whole number or a fraction").
plain_type(between(Low, High), Plain) :-
    format(string(Plain), "a number from ~w to ~w", [Low, High]).
plain_type(character, "one character").
plain_type(char, "one character").
plain_type(chars, "a list of characters").
plain_type(character_code, "the code of a character").
plain_type(code, "the code of a character").
plain_type(codes, "a list of codes of characters").
plain_type(text, "text").
plain_type(string, "a string").
plain_type(compound, "a term with arguments").
plain_type(pair, "a pair Key-Value").
plain_type(sort_key, "the number of an argument, from 0").
plain_type(boolean, "true or false").
plain_type(bool, "true or false").
plain_type(order, "<, = or >").
plain_type(acyclic, "a term that does not contain itself").
plain_type(predicate_indicator, "a word as Name/Arity").
plain_type(dict, "a dict").
plain_type(any, "any term").
plain_type(var, "a variable").
plain_type(nonvar, "a value").
plain_type(ground, "a term without variables").
plain_type(cyclic, "a term that contains itself").

domain_in_words(Domain, Plain) :-
    (   plain_domain(Domain, Plain)
    ->  true
    ;   type_in_words(Domain, Plain)
    ).

plain_domain(not_less_than_zero, "a number from 0").
plain_domain(not_less_than_one, "a number from 1").
plain_domain(non_empty_list, "a list with something in it").
plain_domain(non_empty_atom, "a name of one character or more").
plain_domain(order_specifier, "asc(X) or desc(X)").
plain_domain(order, "one of <, =, > (to compare) or @<, @>, @=<, @>= (to sort)").
plain_domain(acyclic_term, "a term that does not contain itself").

evaluation_in_words(What, Format) :-
    (   plain_evaluation(What, Format)
    ->  true
    ;   Format = "computes what has no value"
    ).

plain_evaluation(zero_divisor, "divides by 0").
plain_evaluation(undefined, "computes what has no value, such as 0/0 or the root of -1").
plain_evaluation(float_overflow, "computes a number that is too large, or infinite").
plain_evaluation(float_underflow, "computes a number that is too close to 0").
plain_evaluation(int_overflow, "computes a number that is too large").
plain_evaluation(rational_overflow, "computes a number that is too large, or infinite").

spaced(Type, Plain) :-
    format(string(Text), "~w", [Type]),
    split_string(Text, "_", "", Words),
    atomic_list_concat(Words, ' ', Joined),
    format(string(Plain), "what is called ~w", [Joined]).

%   A term as one would write it; what has no value is an underscore.
shown(plain(Text), Text) :- !.
shown(Term, Text) :-
    copy_term_nat(Term, Copy),
    term_variables(Copy, Variables),
    maplist(=('$VAR'('_')), Variables),
    format(string(Text), "~W", [Copy, [quoted(true), numbervars(true), max_depth(12)]]).

                 /*******************************
                 *           THE PLACE          *
                 *******************************/

%   Context names the predicate that threw: one that people may call, or a part of one.
word_called(Context, Word) :-
    word_of(Context, Candidates),
    member(Word, Candidates),
    known_word(Word),
    !.

word_of(Context, Candidates) :-
    nonvar(Context),
    Context = context(Called, _),
    nonvar(Called),
    strip_module(Called, _, Name/Arity),
    atom(Name),
    integer(Arity),
    findall(Word, ( Word = Name/Arity ; part_of(Name/Arity, Word) ), Candidates).

known_word(Name/Arity) :-
    (   functor(Goal, Name, Arity),
        allowed_word(Goal, _)
    ->  true
    ;   arithmetic(Name/Arity)
    ).

%   What library predicates are made of, and those that people call.
part_of('$memberchk'/3, memberchk/2).
part_of(max_member_/3, max_member/2).
part_of(min_member_/3, min_member/2).
part_of('$seek_list'/4, nth0/3).
part_of('$seek_list'/4, nth1/3).
part_of((>)/2, limit/2).
part_of((>)/2, offset/2).
part_of('$btree_find_node'/5, distinct/1).

%   place_of_error(+Error, +Text, -Word, -Start, -End) is semidet.
%
%   Where in the question Text the word is that threw Error; fails if it is there several times, or
%   not at all.

place_of_error(error(Formal, Context), Text, Word, Start, End) :-
    read_question(Text, Goal, Position, _),
    (   word_of(Context, Candidates)
    ->  member(Word, Candidates),
        findall(Word-At, place_of_word(Goal, Position, Word, At), Places),
        Places \== []
    ;   findall(Each-At, ( nameless(Formal, Each), place_of_word(Goal, Position, Each, At) ), Places)
    ),
    !,
    Places = [Word-Place],
    span(Place, Start, End).

%   Words that throw such an error without their name.
nameless(type_error(evaluable, _), Word) :-
    !,
    member(Word, [is/2, (=:=)/2, (=\=)/2, (<)/2, (>)/2, (=<)/2, (>=)/2, aggregate_all/3,
                  aggregate_all/4, sum_list/2, sumlist/2, max_list/2, min_list/2]).
nameless(_, Word) :-
    member(Word, [order_by/2, offset/2, limit/2, call_nth/2, nth0/3, nth1/3, nth0/4, nth1/4,
                  numlist/3, predsort/3]).

place_of_word(Term, Position, Name/Arity, Position) :-
    callable(Term),
    functor(Term, Name, Arity),
    Arity > 0.
place_of_word(Term, Position, Word, Found) :-
    compound(Term),
    compound_name_arity(Term, _, Arity),
    between(1, Arity, Index),
    arg(Index, Term, Part),
    compound(Part),
    argument_position(Position, Index, PartPosition),
    place_of_word(Part, PartPosition, Word, Found).

%!  placed(+Kind0, +Message0, +Place0, +Error, +Operation, +Text, -Kind, -Message, -Place) is det.
%
%   Where in the question, or in which model, a goal went wrong; Operation and Text are the request.

placed("prolog", _, [], Error, "query", Text, "question", Message, [Start, End]) :-
    term_string(query(_, _, _, _, _, Question), Text),
    place_of_error(Error, Question, Word, Start, End),
    plain_error(Error, Word, Message),
    !.
placed("prolog", Message0, [], _, _, Text, "prolog", Message, []) :-
    catch(term_string(request(_, _, _, Request), Text), _, fail),
    compound(Request),
    Request =.. [Name, _, Model|_],
    memberchk(Name, [judge, why, why_not]),
    !,
    format(string(Message), "model ~w: ~s", [Model, Message0]).
placed(Kind, Message, Place, _, _, _, Kind, Message, Place).

                 /*******************************
                 *      FAULTS OF REQUESTS      *
                 *******************************/

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
nothing_of(part, "the scene has no part ~w for this model").
nothing_of(single_part, "~w is a set: why-not is asked of single parts, and why of both").
nothing_of(member, "~w: the set has no members of that kind").
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
