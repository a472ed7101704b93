:- module(facetlog_seen_through, [ no_models/1,          % +Test
                                  written_out/2,        % +Test, -Test
                                  one_of/5,             % +X, +List, +Test, -Fresh, -Member
                                  two_of/6,             % +X, +Y, +List, +Test, -Fresh, -Pair
                                  meaning_of/4,         % +Test, +Context, -Sort, -Meaning
                                  relation_code/3,      % +Test, +Context, -Truth
                                  conjuncts/2,          % +Goal, -Goals
                                  conjunction/2,        % +Codes, -Code
                                  disjunction/2         % +Codes, -Code
                                ]).

/** <module> What can be seen of a test before it is asked

Its quantifiers, words and relations, for state_code.pl and outline_code.pl.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog(vocabulary)).

%!  no_models(+Test) is det.
%
%   Verdicts of other models depend on what is being judged (model_test.pl): such rules stay as they
%   are.
%
%   @throws facetlog_general(Test) if it asks for verdicts, or is a variable.

no_models(Test) :-
    (   nonvar(Test),
        \+ sub_model(Test)
    ->  true
    ;   throw(facetlog_general(Test))
    ).

sub_model(Test) :-
    compound(Test),
    (   Test = is_a(_, _)
    ->  true
    ;   arg(_, Test, Arg),
        sub_model(Arg)
    ).

                 /*******************************
                 *          QUANTIFIERS         *
                 *******************************/

%!  written_out(+Test, -Plain) is semidet.
%
%   A quantifier over a list that is written in the test.

written_out(each(X, List, Test), all(Tests)) :-
    is_list(List),
    var(X),
    maplist(instance([X], Test), List, Tests).
written_out(some(X, List, Test), any(Tests)) :-
    is_list(List),
    var(X),
    maplist(instance([X], Test), List, Tests).
written_out(each_pair(X, Y, List, Test), all(Tests)) :-
    is_list(List),
    var(X),
    var(Y),
    pairs(List, Pairs),
    maplist(instance([X, Y], Test), Pairs, Tests).

instance([X], Test, Y, Fresh) :- !, renamed([X], Test, [Y], Fresh).
instance(Variables, Test, New, Fresh) :- renamed(Variables, Test, New, Fresh).

pairs([], []).
pairs([X|List], Pairs) :-
    maplist(pair_with(X), List, First),
    pairs(List, Rest),
    append(First, Rest, Pairs).

pair_with(X, Y, [X, Y]).

%!  one_of(+X, +List, +Test, -Fresh, -Member) is semidet.
%!  two_of(+X, +Y, +List, +Test, -Fresh, -Pair) is semidet.
%
%   Member, or Pair, binds variables that stand in Fresh for X and Y in Test.

one_of(X, List, Test, Fresh, lists:member(Y, List)) :-
    var(X),
    renamed([X], Test, [Y], Fresh).

two_of(X, Y, List, Test, Fresh, facetlog_outlines:pair_of(List, A, B)) :-
    var(X),
    var(Y),
    renamed([X, Y], Test, [A, B], Fresh).

%   Test with other variables in the place of these; the others stay.
renamed(Variables, Test, New, Fresh) :-
    term_variables(Test, All),
    exclude(among(Variables), All, Kept),
    copy_term(t(Variables, Kept, Test), t(New, Kept, Fresh)).

                 /*******************************
                 *             WORDS            *
                 *******************************/

%!  meaning_of(+Test, +Context, -Sort, -Meaning) is semidet.
%
%   The words of the vocabulary (general) are written out, those of the rules (own) remembered.

meaning_of(Test, context(Module, _, _), Sort, Meaning) :-
    callable(Test),
    (   current_predicate(Module:means/2),
        \+ predicate_property(Module:means(_, _), imported_from(_)),
        meant(Module, Test, Meaning0)
    ->  Sort = own,
        Meaning = Meaning0
    ;   Sort = general,
        meant(vocabulary, Test, Meaning)
    ).

%   Only a word whose meaning does not depend on what its arguments are.
meant(Module, Test, Meaning) :-
    copy_term(Test, Copy),
    findall(Test-Meaning0, Module:means(Test, Meaning0), [Copy1-_|_]),
    Copy1 =@= Copy,
    once(Module:means(Test, Meaning)).

                 /*******************************
                 *           RELATIONS          *
                 *******************************/

%!  relation_code(+Test, +Context, -Truth) is semidet.
%
%   Truth is settled(Goal, Unseen) or either(For, Against).

relation_code(Test, Context, Truth) :-
    findall(Test-Body, clause(vocabulary:truth(Test, _), Body), Bodies),
    Bodies = [_-_],
    copy_term(Test, Copy),
    clause(vocabulary:truth(Test, _), Body),
    Copy =@= Test,
    (   Body = settled(Goal, _)
    ->  body_code(vocabulary:Goal, Context, Code),
        Test =.. [_|Parts],
        maplist(unseen_code, Parts, Unseen),
        disjunction(Unseen, AnyUnseen),
        Truth = settled(Code, AnyUnseen)
    ;   Body = either(For0, Against0, _),
        body_code(vocabulary:For0, Context, For),
        body_code(vocabulary:Against0, Context, Against),
        Truth = either(For, Against)
    ).

unseen_code(Parts, memberchk(unseen, Parts)) :-
    is_list(Parts),
    !.
unseen_code(Part, Part == unseen).

                 /*******************************
                 *             GOALS            *
                 *******************************/

%!  conjuncts(+Goal, -Goals) is det.
%
%   The steps of a goal.

conjuncts(Goal, [Goal]) :- var(Goal), !.
conjuncts(true, []) :- !.
conjuncts((A, B), Goals) :-
    !,
    conjuncts(A, As),
    conjuncts(B, Bs),
    append(As, Bs, Goals).
conjuncts(Goal, [Goal]).

%!  conjunction(+Codes, -Code) is det.
%!  disjunction(+Codes, -Code) is det.

conjunction([], true).
conjunction([Code|Codes], All) :- foldl(and_then, Codes, Code, All).

and_then(Code, Before, ( Before, Code )).

disjunction([], fail).
disjunction([Code|Codes], ( Code -> true ; Rest )) :- disjunction(Codes, Rest).
