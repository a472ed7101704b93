:- module(facetlog_members, [ add_near/3,         % +Module, +Verdict0, -Verdict
                              set_roles/3,        % +Module, +Model, -Roles
                              asked_member/7      % +Module, +Model, +Thing, +Parts, +Role, +Name, -Asked
                            ]).

/** <module> What comes nearest to a set that has too few or too many members

A model's clauses run as they are but for `possible/1`, by which a search leaves out what cannot be a
member: so each part of the thing is tested by the set's own words.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(prove)).
:- use_module(facetlog_kb(say)).

%   As many as a line can name; each is proved.
most_near(20).

%!  add_near(+Module, +Verdict0, -Verdict) is det.
%
%   Each condition of Verdict0 (judge.pl) that does not hold gets a further argument: a list of
%   near(Sort, Member, Proof, Within), the nearest first. Sort is `few` for what is no member and could be
%   one, `many` for members of which there are too many, first those that the least change would make
%   none. Within is such a list where a member lacks nothing but members of sets of its own.

add_near(Module, Verdict0, Verdict) :-
    Verdict0 = verdict(Model, Thing, S, L, H, Roled, Sizes, Conditions0, Also, General),
    findall(Part, member(_-Part, Roled), Parts),
    while_judging(Module, Model, Thing,
                  maplist(condition_with_near(Module, Model, Thing, Parts), Conditions0, Conditions)),
    Verdict = verdict(Model, Thing, S, L, H, Roled, Sizes, Conditions, Also, General).

condition_with_near(Module, Model, Thing, Parts, condition(Label, Reason, Proof, Place, Text),
                    condition(Label, Reason, Proof, Place, Text, Near)) :-
    (   Proof = proof(holds, _, _, _, _, _)
    ->  Near = []
    ;   findall(One,
                ( clause(Module:condition(Model, Label, _, Thing, Parts, Test), Body),
                  run(Body, Module),
                  form_in(Test, Form),
                  near_form(Form, Module, One) ),
                Near)
    ).

%   Solutions of a clause's body, whatever `possible/1` says.
run((A, B), Module) :- !, run(A, Module), run(B, Module).
run(findall(Template, Goal, List), Module) :- !, findall(Template, run(Goal, Module), List).
run(possible(_), _) :- !.
run(members(Model, Role, Thing, Parts, Members), Module) :-
    !,
    clause(Module:members(Model, Role, Thing, Parts, Members), Body),
    run(Body, Module).
run(Goal, Module) :- call(Module:Goal).

%   The sets that a test counts. Of alternatives they decide only where all are sets.
form_in(Test, Form) :-
    (   form_parts(Test, Tests)
    ->  member(One, Tests),
        form_in(One, Form)
    ;   Form = Test
    ).

form_parts(all(Tests), Tests).
form_parts(any(Tests), Tests) :- forall(member(Test, Tests), form_set(Test, _, _, _, _)).
form_parts(if_known(Test), [Test]).

%   form_set(Form, Sort, X, Members, Test): Test says of X whether it is one of those that are counted.
form_set(at_least_in(_, _, X, Groups, Test), few, X, Members, Test) :- append(Groups, Members).
form_set(at_least_of(_, X, Groups, Test), few, X, Members, Test) :- append(Groups, Members).
form_set(some(X, Members, Test), few, X, Members, Test).
form_set(at_most_of(_, X, Groups, Test), many, X, Members, Test) :- append(Groups, Members).

near_form(Form, Module, near(Sort, Member, Proof, Within)) :-
    form_set(Form, Sort, X, Members, Test),
    state(Form, Module, State),
    ( Sort == few -> State \== holds ; State == fails ),
    findall(Rank-(Member-Instance),
            ( member(Member, Members),
              instance([X], Test, [Member], Instance),
              near_rank(Sort, Instance, Module, Rank) ),
            Ranked),
    keysort(Ranked, Sorted),
    pairs_values(Sorted, All),
    most_near(Most),
    length(All, Count),
    Shown is min(Most, Count),
    length(Near, Shown),
    append(Near, _, All),
    member(Member-Instance, Near),
    evaluate(Instance, Module, Proof),
    single_tests(Instance, Module, Tests),
    findall(One, ( member(One, Tests), \+ state(One, Module, holds) ), Lacking),
    (   forall(member(One, Lacking), form_set(One, few, _, _, _))
    ->  findall(Near1, ( member(One, Lacking), near_form(One, Module, Near1) ), Within)
    ;   Within = []
    ).

%   First what fails in the fewest tests, of these what fails by the least; of members the least probable.
near_rank(few, Test, Module, rank(Failing, Miss)) :-
    outline(Test, Module, outline(State, _, _, Miss)),
    State \== holds,
    single_tests(Test, Module, Tests),
    findall(One, ( member(One, Tests), state(One, Module, fails) ), Failed),
    length(Failed, Failing).
near_rank(many, Test, Module, Low) :-
    outline(Test, Module, outline(holds, Low, _, _)).

single_tests(Test, Module, Tests) :-
    (   Test = all(Parts)
    ->  findall(One, ( member(Part, Parts), single_tests(Part, Module, Ones), member(One, Ones) ), Tests)
    ;   current_predicate(Module:means/2),
        Module:means(Test, Meaning)
    ->  single_tests(Meaning, Module, Tests)
    ;   Tests = [Test]
    ).

                 /*******************************
                 *      ONE MEMBER OF A SET     *
                 *******************************/

%!  set_roles(+Module, +Model, -Roles) is det.
%
%   Roles are the names of the sets of Model.

set_roles(Module, Model, Roles) :-
    findall(Role, set_clause(Module, Model, _, _, Role, _, _, _, _), Roles).

%   What the model language compiles a set to: Before finds Members, and Test says which X of these are
%   of the set.
set_clause(Module, Model, Thing, Parts, Role, Before, X, Members, Test) :-
    current_predicate(Module:group/5),
    clause(Module:group(Model, Thing, Parts, Role, _),
           ( Before, findall(X, ( member(X, Members), holds(Test) ), _) )).

%!  asked_member(+Module, +Model, +Thing, +Parts, +Role, +Name, -Asked) is det.
%
%   Asked is asked(Role, Name, Played, Proof): whether Name belongs to the set Role where Parts are the
%   other parts. Played lists the parts that it is one of, which keeps it from being a member.
%
%   @error existence_error(member, Role=Name) if it is of another kind than the set's members

asked_member(Module, Model, Thing, Parts, Role, Name, asked(Role, Name, Played, Proof)) :-
    once(Module:model(Model, _, Roles)),
    pairs_keys_values(Roled, Roles, Parts),
    findall(Other, ( member(Other-Part, Roled), ( Part == Name ; is_list(Part), memberchk(Name, Part) ) ),
            Played),
    set_clause(Module, Model, Thing, Parts, Role, Before, X, Members, Test),
    !,
    run(Before, Module),
    (   ( Played \== [] ; memberchk(Name, Members) )
    ->  true
    ;   existence_error(member, Role=Name)
    ),
    instance([X], Test, [Name], Instance),
    while_judging(Module, Model, Thing, evaluate(Instance, Module, Proof)).
