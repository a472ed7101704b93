:- module(facetlog_bounded_text, [ bounded_text_word/2,          % ?Indicator, -Bounded
                                   renew_text_budget/0,
                                   bounded_atom_concat/3,       % ?A, ?B, ?AB
                                   bounded_atomic_list_concat/2, % +Parts, -Atom
                                   bounded_atomic_list_concat/3, % ?Parts, +Separator, ?Atom
                                   bounded_sub_atom/5,          % +Atom, ?Before, ?Length, ?After, ?Sub
                                   bounded_atom_string/2,       % ?Atom, ?String
                                   bounded_atom_codes/2,        % ?Atom, ?Codes
                                   bounded_atom_chars/2,        % ?Atom, ?Chars
                                   bounded_atom_number/2,       % ?Atom, ?Number
                                   bounded_number_string/2,     % ?Number, ?String
                                   bounded_number_codes/2,      % ?Number, ?Codes
                                   spend_on_answer/1,           % +Answer
                                   bounded_functor/3,           % ?Term, ?Name, ?Arity
                                   bounded_univ/2               % ?Term, ?List
                                 ]).

/** <module> Words that make atoms, with a budget

Atoms live outside the stacks, and so outside their limit: a rule that doubles an atom forty times
would take all memory of the machine. So a chunk of answers, or a verdict, may make atoms of so many
characters in all.
*/

:- use_module(library(lists)).
:- use_module(library(error)).

%   Characters. A million names of ten characters take some 100 MB.
budget(10_000_000).

%   The digits of a number that is read from text: twice as many take four times as long, and 10 ms
%   are spent on these.
longest_number(20_000).

%   What an answer counts that is remembered since each shall be given once (170 bytes, measured).
remembered_answer(20).

%   What the name of a compound counts that was not there before: Prolog never forgets it.
new_functor(1_000).

%!  bounded_text_word(?Indicator, -Bounded) is nondet.
%
%   The predicate Bounded is called in the place of Indicator.

bounded_text_word(atom_concat/3, bounded_atom_concat).
bounded_text_word(atomic_list_concat/2, bounded_atomic_list_concat).
bounded_text_word(atomic_list_concat/3, bounded_atomic_list_concat).
bounded_text_word(sub_atom/5, bounded_sub_atom).
bounded_text_word(atom_string/2, bounded_atom_string).
bounded_text_word(atom_codes/2, bounded_atom_codes).
bounded_text_word(atom_chars/2, bounded_atom_chars).
bounded_text_word(atom_number/2, bounded_atom_number).
bounded_text_word(number_string/2, bounded_number_string).
bounded_text_word(number_codes/2, bounded_number_codes).
bounded_text_word(functor/3, bounded_functor).
bounded_text_word((=..)/2, bounded_univ).

%!  renew_text_budget is det.
%
%   A question begins.

renew_text_budget :-
    budget(Budget),
    nb_setval(facetlog_text_budget, Budget).

%!  spend(+Characters) is det.
%
%   @error resource_error(text) if the budget is used up.

spend(Characters) :-
    ( nb_current(facetlog_text_budget, Before) -> true ; budget(Before) ),
    Left is Before - Characters,
    (   Left >= 0
    ->  nb_setval(facetlog_text_budget, Left)
    ;   resource_error(text)
    ).

spend_on(Text) :-
    (   nonvar(Text)
    ->  atom_length(Text, Length),
        spend(Length)
    ;   true
    ).

%!  bounded_atom_concat(?A, ?B, ?AB) is nondet.
%
%   What the word of its name does, for a price; so each of the words below.
%
%     ==
%     bounded_atom_concat(A, B, AB) :- atom_concat(A, B, AB).
%     ==
%
%   @error resource_error(text) if the atoms of this question come to more than the budget.

bounded_atom_concat(A, B, AB) :-
    (   nonvar(A),
        nonvar(B)
    ->  spend_on(A),
        spend_on(B),
        atom_concat(A, B, AB)
    ;   atom_concat(A, B, AB),
        spend_on(AB)
    ).

%!  bounded_atomic_list_concat(+Parts, -Atom) is det.
%
%   @error resource_error(text), before anything is made

bounded_atomic_list_concat(Parts, Atom) :-
    spend_on_all(Parts, 0),
    atomic_list_concat(Parts, Atom).

%!  bounded_atomic_list_concat(?Parts, +Separator, ?Atom) is semidet.
%
%   Joins, or with unknown Parts splits.
%
%   @error resource_error(text), before anything is made

bounded_atomic_list_concat(Parts, Separator, Atom) :-
    (   ground(Parts),
        atomic(Separator)
    ->  atom_length(Separator, Length),
        spend_on_all(Parts, Length)
    ;   spend_on(Atom)
    ),
    atomic_list_concat(Parts, Separator, Atom).

%   Before anything is made: a short list can be long text.
spend_on_all(Parts, More) :-
    must_be(list, Parts),
    forall(( member(Part, Parts), atomic(Part) ),
           ( atom_length(Part, Length),
             Spent is Length + More,
             spend(Spent) )).

%!  bounded_sub_atom(+Atom, ?Before, ?Length, ?After, ?Sub) is nondet.
%
%   @error resource_error(text)

bounded_sub_atom(Atom, Before, Length, After, Sub) :-
    sub_atom(Atom, Before, Length, After, Sub),
    spend(Length).

%!  bounded_atom_string(?Atom, ?String) is semidet.
%!  bounded_atom_codes(?Atom, ?Codes) is semidet.
%!  bounded_atom_chars(?Atom, ?Chars) is semidet.
%
%   Only an atom that is made costs.
%
%   @error resource_error(text)

bounded_atom_string(Atom, String) :-
    ( nonvar(Atom) -> true ; spend_on(String) ),
    atom_string(Atom, String).

bounded_atom_codes(Atom, Codes) :-
    ( nonvar(Atom) -> true ; spend_on_list(Codes) ),
    atom_codes(Atom, Codes).

bounded_atom_chars(Atom, Chars) :-
    ( nonvar(Atom) -> true ; spend_on_list(Chars) ),
    atom_chars(Atom, Chars).

spend_on_list(Items) :-
    (   is_list(Items)
    ->  length(Items, Length),
        spend(Length)
    ;   spend_on(Items)
    ).

%!  bounded_atom_number(?Atom, ?Number) is semidet.
%!  bounded_number_string(?Number, ?String) is semidet.
%!  bounded_number_codes(?Number, ?Codes) is semidet.
%
%   Reading and writing a number takes time that grows with the square of its digits.
%
%   @error resource_error(number_length) if it has more digits than longest_number/1
%   @error resource_error(text)

bounded_atom_number(Atom, Number) :-
    must_be_short(Atom),
    must_be_short_number(Number, Length),
    (   var(Atom),
        number(Number)
    ->  spend(Length)
    ;   true
    ),
    atom_number(Atom, Number).

bounded_number_string(Number, String) :-
    must_be_short(String),
    must_be_short_number(Number, _),
    number_string(Number, String).

bounded_number_codes(Number, Codes) :-
    must_be_short(Codes),
    must_be_short_number(Number, _),
    number_codes(Number, Codes).

%   Length is at least that of the number's text.
must_be_short_number(Number, Length) :-
    (   rational(Number, Numerator, Denominator)
    ->  digits(Numerator, N),
        digits(Denominator, D),
        longest_number(Most),
        Length is N + D,
        (   max(N, D) > Most
        ->  resource_error(number_length)
        ;   true
        )
    ;   Length = 32                     % of a float
    ).

digits(Integer, Digits) :-
    Digits is 2 + msb(max(1, abs(Integer)))*30103//100000.

must_be_short(Text) :-
    longest_number(Most),
    (   var(Text)
    ->  true
    ;   is_list(Text)
    ->  length(Text, Length)
    ;   atom_length(Text, Length)
    ),
    (   nonvar(Length),
        Length > Most
    ->  resource_error(number_length)
    ;   true
    ).

%!  spend_on_answer(+Answer) is det.
%
%   Answer is one that distinct/1 or distinct/2 remembers, outside the stacks.
%
%   @error resource_error(text) if the budget is used up.

spend_on_answer(Answer) :-
    remembered_answer(Least),
    term_size(Answer, Cells),
    Spent is Least + Cells,
    spend(Spent).

%!  bounded_functor(?Term, ?Name, ?Arity) is det.
%!  bounded_univ(?Term, ?List) is det.
%
%   As functor/3 and (=..)/2: a compound whose name and arity were not there before costs.
%
%   @error resource_error(text)

bounded_functor(Term, Name, Arity) :-
    ( nonvar(Term) -> true ; spend_on_functor(Name, Arity) ),
    functor(Term, Name, Arity).

bounded_univ(Term, List) :-
    (   nonvar(Term)
    ->  true
    ;   must_be(list, List),
        List = [Name|Args],
        length(Args, Arity),
        spend_on_functor(Name, Arity)
    ),
    Term =.. List.

spend_on_functor(Name, Arity) :-
    (   atom(Name),
        integer(Arity),
        Arity > 0,
        \+ current_functor(Name, Arity)
    ->  new_functor(Characters),
        spend(Characters)
    ;   true
    ).
